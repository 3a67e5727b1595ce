"""From one held state to another: making the packet, and applying it."""

from __future__ import annotations

from tilesnav_ref.packet.geometry import decode_body, encode_body
from tilesnav_ref.packet.model import Limits, PacketError
from tilesnav_ref.packet.plain import decode_plain, encode_plain
from tilesnav_ref.packet.state import HeldState, Parts, check_parts
from tilesnav_ref.packet.wire import CODED, NO_MARK, PLAIN, Packet


def make_packet(before: HeldState | None, after: HeldState) -> Packet:
    """Return the packet that leads from a state to another.

    Parameters
    ----------
    before : HeldState or None
        What the vehicle holds; None for a key frame.
    after : HeldState
        What it is to hold, of the same map.

    Returns
    -------
    Packet
        Its body is coded, or plain where an object or a face has a number that is too large for that.
    """
    if before is not None and before.map_name != after.map_name:
        raise ValueError(f"states of the maps {before.map_name.hex()} and {after.map_name.hex()}")
    codec, body = _encode(() if before is None else before.parts, after.parts)
    return Packet(
        map_name=after.map_name,
        before_cell=None if before is None else before.cell,
        before_mark=NO_MARK if before is None else before.mark,
        cell=after.cell,
        mark=after.mark,
        exact=after.exact,
        codec=codec,
        body=body,
    )


def applies(packet: Packet, held: HeldState | None) -> bool:
    """Whether a packet applies to what is held."""
    return packet.is_key_frame or (
        held is not None and (packet.before_cell, packet.before_mark) == (held.cell, held.mark)
    )


def apply_packet(packet: Packet, held: HeldState | None, limits: Limits) -> HeldState:
    """Return the state that results from a packet.

    Parameters
    ----------
    packet : Packet
        For the map of what is held.
    held : HeldState or None
        A state that the packet applies to.
    limits : Limits
        How much the vehicle may hold.

    Raises
    ------
    PacketError
        When it does not apply, its body is not sound, or what results has another mark.
    """
    if not applies(packet, held):
        raise PacketError(f"a packet for another state of cell {packet.before_cell} than the one held")
    before = () if packet.is_key_frame or held is None else held.parts
    parts = _decode(packet, before, limits)
    known = {id(part) for part in before}
    # What was held is sound; what is new comes from outside.
    check_parts([part for part in parts if id(part) not in known], limits)
    state = HeldState(packet.map_name, packet.cell, packet.exact, parts)
    if len(parts) > limits.objects or state.face_count > limits.faces:
        found = f"{len(parts)} objects, {state.face_count} faces"
        raise PacketError(f"{found} held; allowed: {limits.objects} objects, {limits.faces} faces")
    if state.mark != packet.mark:
        raise PacketError(f"mark {state.mark.hex()} of what results; allowed: {packet.mark.hex()}, as stated")
    return state


def _encode(before: Parts, after: Parts) -> tuple[int, bytes]:
    """Codec and body."""
    try:
        return CODED, encode_body(before, after)
    except PacketError:  # numbers that only the plain codec can carry
        return PLAIN, encode_plain(before, after)


def _decode(packet: Packet, before: Parts, limits: Limits) -> Parts:
    if packet.codec == PLAIN:
        return decode_plain(packet.body, before, limits)
    return decode_body(packet.body, before, limits)

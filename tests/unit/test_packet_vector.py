"""The worked example of the specification, byte by byte, as it was computed without this code."""

from __future__ import annotations

import re
import struct
import zlib
from hashlib import sha256
from pathlib import Path

import numpy as np

from tilesnav_ref.packet.client import PacketClient, Verdict
from tilesnav_ref.packet.model import Limits, ObjectFaces
from tilesnav_ref.packet.plain import decode_plain, encode_plain
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.packet.wire import read_sequence

ROOT = Path(__file__).resolve().parents[2]
SPEC = (ROOT / "spec" / "README.md").read_text(encoding="utf-8")
TILESET = ROOT / "conformance" / "cases" / "valid" / "one-cell-proved" / "tileset.json"
GROUND = (
    ((-8192, -8192, 0), (8192, -8192, 0), (8192, 8192, 0)),
    ((-8192, -8192, 0), (8192, 8192, 0), (-8192, 8192, 0)),
)
WALL = ((0, -2048, 0), (0, 2048, 0), (0, 2048, 4096)), ((0, -2048, 0), (0, 2048, 4096), (0, -2048, 4096))
SHEET = (
    ((-1024, -1024, 512), (-1024, 1024, 512), (-1024, 1024, 2048)),
    ((-1024, -1024, 512), (-1024, 1024, 2048), (-1024, -1024, 2048)),
)
HEADERS = (
    "76657031 01000000 9b6b2d9502e46889 ffffffff00000000 0000000000000000 bb83b01517b543d6 3701000000000000",
    "76657031 02000000 9b6b2d9502e46889 0000000000000000 bb83b01517b543d6 da95209a1966044e 1b00000000000000",
)
SECOND_BODY = "0c000000 7801 01 0c00f3ff 01000000 02000000 00000000 00280004"


def dump() -> bytes:
    """Bytes that the specification prints, each line at the offset that it states."""
    fence = r"^```hexdump valid/packets-worked-example/walk.vep\n(.*?)^```$"
    (body,) = re.findall(fence, SPEC, re.MULTILINE | re.DOTALL)
    data = b""
    for line in body.splitlines():
        if not line.startswith("#"):
            found = re.fullmatch(r"([0-9a-f]{6})  ((?:[0-9a-f]{2} )+) *(?:\S.*)?", line)
            assert found, line
            assert int(found[1], 16) == len(data), line
            data += bytes.fromhex(found[2])
    return data


def parts(*objects: tuple[tuple[tuple[int, ...], ...], ...]) -> tuple[ObjectFaces, ...]:
    return tuple(
        ObjectFaces(i, 0, 0, np.arange(len(one), dtype=np.uint32), np.array(one, np.int32))
        for i, one in enumerate(objects)
    )


def key_frame_body() -> bytes:
    """Laid out by hand: one stored block."""
    raw = struct.pack("<II", 0, 3)
    for number, faces in enumerate((GROUND, WALL, SHEET)):
        raw += struct.pack("<IBBHI3I", number, 0, 0, 1, 0, 2, 0, 1) + np.array(faces, "<i4").tobytes()
    stream = b"\x78\x01\x01" + struct.pack("<HH", len(raw), len(raw) ^ 0xFFFF) + raw
    return struct.pack("<I", len(raw)) + stream + struct.pack(">I", zlib.adler32(raw))


def test_the_example_is_laid_out_as_the_text_says() -> None:
    first, second = (bytes.fromhex(header) for header in HEADERS)
    assert dump() == first + key_frame_body() + second + bytes.fromhex(SECOND_BODY)
    assert sha256(TILESET.read_bytes()).digest()[:8].hex() == "9b6b2d9502e46889"


def test_states_of_the_example_have_its_marks() -> None:
    name = sha256(TILESET.read_bytes()).digest()[:8]
    one = HeldState(name, 0, False, parts(GROUND, WALL, SHEET))
    other = HeldState(name, 0, True, parts(GROUND, WALL))
    assert (one.mark.hex(), other.mark.hex()) == ("bb83b01517b543d6", "da95209a1966044e")
    ground, wall = (np.array(faces, "<i4").tobytes() for faces in (GROUND, WALL))
    two = struct.pack("<3I", 2, 0, 1)
    head = bytes.fromhex("9b6b2d9502e46889 00000000 01000000 02000000")
    expected = head + struct.pack("<IH", 0, 0) + two + ground + struct.pack("<IH", 1, 0) + two + wall
    assert other.canonical_bytes() == expected
    assert len(expected) == 200


def test_a_client_follows_the_example() -> None:
    client = PacketClient(bytes.fromhex("9b6b2d9502e46889"))
    key_frame, change = read_sequence(dump())
    assert (key_frame.size, change.size) == (359, 75)
    assert client.receive(key_frame.to_bytes()).verdict is Verdict.APPLIED
    assert client.receive(change.to_bytes()).verdict is Verdict.APPLIED
    assert client.state is not None
    assert client.state.exact
    assert [part.corners.tolist() for part in client.state.parts] == np.array((GROUND, WALL)).tolist()


def test_the_plain_body_inflates_to_what_the_example_lists() -> None:
    three, two = parts(GROUND, WALL, SHEET), parts(GROUND, WALL)
    assert zlib.decompress(encode_plain((), three)[4:]) == zlib.decompress(key_frame_body()[4:])
    assert zlib.decompress(encode_plain(three, two)[4:]) == bytes.fromhex("01000000 02000000 00000000")
    assert decode_plain(bytes.fromhex(SECOND_BODY), three, Limits()) == three[:2]

"""Packets: headers, maps, cells, what they apply to, and the states that result."""

from __future__ import annotations

from collections.abc import Iterator

from tilesnav_validator import packets
from tilesnav_validator.checks import check
from tilesnav_validator.checks.cells import FACES
from tilesnav_validator.checks.container import WHOLE
from tilesnav_validator.findings import Finding, Findings, NotRun
from tilesnav_validator.packetjudge import follow
from tilesnav_validator.packetscene import Scene
from tilesnav_validator.subject import Subject

CLASS = "packet"
_HEADERS = ("packet/header", "packet/map", "packet/cells", "packet/before")
_TILESET = (*WHOLE, *FACES, "core/object-flags", "pvs/sorted-faces", "level/objects-whole")


@check("packet/header")
def header(subject: Subject) -> Iterator[Finding]:
    """Headers and lengths."""
    for sequence in subject.sequences:
        yield from sequence.faults


@check("packet/map", needs=("packet/header",))
def of_map(subject: Subject) -> Iterator[Finding]:
    """Packets are for this tileset."""
    for packet in _packets(subject):
        if packet.map != subject.map:
            yield Finding(f"{packet.where} map", packet.map.hex(), subject.map.hex())


@check("packet/cells", needs=("packet/header",))
def cells(subject: Subject) -> Iterator[Finding]:
    """Cells are those of the tileset."""
    limit = subject.number("cellCount")
    for packet in _packets(subject):
        if not packet.is_key and packet.source >= limit:
            yield Finding(f"{packet.where} cell before", str(packet.source), f"less than {limit}")
        if packet.target >= limit:
            yield Finding(f"{packet.where} cell after", str(packet.target), f"less than {limit}")


@check("packet/before", needs=("packet/header", "packet/map", "packet/cells"))
def before(subject: Subject) -> Iterator[Finding]:
    """Every packet applies to the result of an earlier one."""
    for sequence in subject.sequences:
        results: set[tuple[int, bytes]] = set()
        for packet in sequence.packets:
            if not packet.is_key and packet.applies_to not in results:
                measured = f"cell {packet.source}, mark {packet.before.hex()}"
                yield Finding(packet.where, measured, "cell and mark that an earlier packet results in")
            results.add(packet.results_in)


def _packets(subject: Subject) -> Iterator[packets.Packet]:
    for sequence in subject.sequences:
        yield from sequence.packets


def _followed(subject: Subject, requirement: str) -> Findings:
    """What following the sequences brought for a requirement."""
    found = subject.followed or follow(subject.sequences, Scene(subject), subject.settings)
    subject.followed = found
    yield from found.findings[requirement]
    return NotRun(found.unexamined) if found.unexamined else None


@check("packet/body", needs=(*_HEADERS, *_TILESET))
def body(subject: Subject) -> Findings:
    """Bodies can be decoded."""
    return (yield from _followed(subject, "packet/body"))


@check("packet/after", needs=("packet/body",))
def after(subject: Subject) -> Findings:
    """Marks are those of the states that result."""
    return (yield from _followed(subject, "packet/after"))


@check("packet/geometry", needs=("packet/after",))
def geometry(subject: Subject) -> Findings:
    """Parts are those of the tileset."""
    return (yield from _followed(subject, "packet/geometry"))


@check("packet/conservative", needs=("packet/geometry", "level/faces-covered"))
def conservative(subject: Subject) -> Findings:
    """States hold all that the sets of their cells ask for."""
    return (yield from _followed(subject, "packet/conservative"))


@check("packet/exact", needs=("packet/geometry", "level/faces-covered"))
def exact(subject: Subject) -> Findings:
    """States that are said to be exact hold nothing else."""
    return (yield from _followed(subject, "packet/exact"))

"""Deltas on directed portals: spelling, identity, level switches, and paths with cycles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import ragged
from tilesnav_validator.checks import check
from tilesnav_validator.checks.container import WHOLE
from tilesnav_validator.findings import Finding
from tilesnav_validator.subject import Subject
from tilesnav_validator.tables import Ragged, Tables

IntArray = NDArray[np.int64]

_SCRATCH = 2**25
_ELEMENTS = 2**22
_WALKS, _STEPS = 8, 64


def _name(tables: Tables, portal: int) -> str:
    source = int(np.searchsorted(tables.targets.offsets, portal, side="right")) - 1
    return f"portal {portal} from cell {source} to cell {tables.targets.values[portal]}"


@check("delta/sorted", needs=(*WHOLE, "core/face-count"))
def delta_sorted(subject: Subject) -> Iterator[Finding]:
    """Lists of deltas ascend and are in range."""
    tables = subject.tables
    lists = (
        ("entered", tables.entered, "faceCount"),
        ("left", tables.left, "faceCount"),
        ("switchObjects", tables.switch_objects, "objectCount"),
    )
    for name, values, limit_name in lists:
        limit = subject.number(limit_name)
        portals = ragged.rows(values.offsets)
        out = values.values >= limit
        for index in np.flatnonzero(out):
            where = f"{_name(tables, portals[index])} deltas/{name}[{index}]"
            yield Finding(where, str(values.values[index]), f"less than {limit}")
        for index in ragged.not_ascending(values.values, values.offsets):
            if not out[index] and not out[index - 1]:
                where = f"{_name(tables, portals[index])} deltas/{name}[{index}]"
                yield Finding(
                    where, f"{values.values[index]} after {values.values[index - 1]}", "strictly ascending"
                )


def _portions(tables: Tables, lists: Ragged, width: int) -> Iterator[IntArray]:
    """Runs of portals for which a table of ``width`` marks a portal and the lists of both ends stay small."""
    if not len(tables.polygons):
        return
    lengths = np.diff(lists.offsets)
    work = lengths[tables.portal_sources] + lengths[tables.targets.values.astype(np.int64)]
    portion = np.maximum(
        np.cumsum(work) // _ELEMENTS, np.arange(len(work)) // max(1, _SCRATCH // max(width, 1))
    )
    cuts = np.flatnonzero(np.diff(portion)) + 1
    yield from np.split(np.arange(len(work), dtype=np.int64), cuts)


def _expected(
    lists: Ragged, base: IntArray, other: IntArray, scratch: NDArray[np.bool_]
) -> tuple[IntArray, IntArray]:
    """Elements of the lists ``other`` that are not in those of ``base``: row and index of each."""
    row, index = ragged.take(lists.offsets, base)
    scratch[row, lists.values[index]] = True
    other_row, other_index = ragged.take(lists.offsets, other)
    fresh = ~scratch[other_row, lists.values[other_index]]
    scratch[row, lists.values[index]] = False
    return other_row[fresh], other_index[fresh]


def _differing(expected: tuple[IntArray, NDArray[np.uint32]], stored: Ragged, portals: IntArray) -> IntArray:
    """Portals for which the expected rows and values are not those stored."""
    row, values = expected
    stored_row, index = ragged.take(stored.offsets, portals)
    if np.array_equal(row, stored_row) and np.array_equal(values, stored.values[index]):
        return np.zeros(0, np.int64)
    starts = np.searchsorted(row, np.arange(len(portals) + 1))
    wrong = [
        portal
        for at, portal in enumerate(portals)
        if not np.array_equal(values[starts[at] : starts[at + 1]], stored.row(portal))
    ]
    return np.array(wrong, dtype=np.int64)


@check(
    "delta/identity", needs=("delta/sorted", "pvs/sorted-faces", "portal/target-exists", "core/face-count")
)
def identity(subject: Subject) -> Iterator[Finding]:
    """Each delta alone; when all are right, deltas composed along random paths that visit cells again."""
    tables, width = subject.tables, subject.number("faceCount")
    lists, right = tables.faces, True
    for portals in _portions(tables, lists, width):
        ends = tables.portal_sources[portals], tables.targets.values[portals].astype(np.int64)
        scratch = np.zeros((len(portals), width), dtype=bool)
        for name, stored, base, other in (
            ("entered", tables.entered, *ends),
            ("left", tables.left, *ends[::-1]),
        ):
            row, index = _expected(lists, base, other, scratch)
            for portal in _differing((row, lists.values[index]), stored, portals):
                right = False
                yield _difference(tables, portal, name)
    if right:
        yield from _paths(subject)


def _difference(tables: Tables, portal: int, name: str) -> Finding:
    """What is missing from the faces entered or left of a delta, and what is too many."""
    source = int(tables.portal_sources[portal])
    ends = tables.faces.row(source), tables.faces.row(int(tables.targets.values[portal]))
    if name == "entered":
        wanted, stored = np.setdiff1d(ends[1], ends[0]), tables.entered.row(portal)
    else:
        wanted, stored = np.setdiff1d(ends[0], ends[1]), tables.left.row(portal)
    missing, extra = np.setdiff1d(wanted, stored), np.setdiff1d(stored, wanted)
    lacks = f"{len(missing)} missing {missing[:5].tolist()}"
    measured = f"faces {name}: {lacks}, {len(extra)} too many {extra[:5].tolist()}"
    return Finding(_name(tables, portal), measured, f"the {len(wanted)} faces of the difference")


def _paths(subject: Subject) -> Iterator[Finding]:
    """Follow deltas along seeded random paths and back; the faces must be those stored of every cell on the
    way."""
    tables = subject.tables
    starts = np.flatnonzero(np.diff(tables.targets.offsets))
    if not len(starts):
        return
    random = np.random.Generator(np.random.SFC64([subject.settings.seed, 1]))
    for start in random.choice(starts, _WALKS):
        cell, held = int(start), set(tables.faces.row(int(start)).tolist())
        for _ in range(_STEPS):
            low, high = tables.targets.offsets[cell : cell + 2]
            if low == high:
                break
            portal = int(random.integers(low, high))
            held = held.difference(tables.left.row(portal).tolist()).union(
                tables.entered.row(portal).tolist()
            )
            cell = int(tables.targets.values[portal])
            if held != set(tables.faces.row(cell).tolist()):
                yield Finding(
                    f"path from cell {start} to cell {cell}", "other faces than stored", "the stored faces"
                )
                return


@check("delta/switches", needs=("delta/sorted", "lod/objects-match", "portal/target-exists"))
def switches(subject: Subject) -> Iterator[Finding]:
    """Objects switched are those whose code is new or other, with the code in the target."""
    tables, width = subject.tables, subject.number("objectCount")
    objects, codes = tables.objects, tables.codes.values
    for portals in _portions(tables, objects, width):
        held = np.full((len(portals), width), -1, dtype=np.int16)
        row, index = ragged.take(objects.offsets, tables.portal_sources[portals])
        held[row, objects.values[index]] = codes[index]
        row, index = ragged.take(objects.offsets, tables.targets.values[portals].astype(np.int64))
        fresh = held[row, objects.values[index]] != codes[index]
        row, index = row[fresh], index[fresh]
        wrong = _differing((row, objects.values[index]), tables.switch_objects, portals)
        for portal in wrong:
            stored = tables.switch_objects.row(portal)
            measured = f"{len(stored)} objects switched {stored[:8].tolist()}"
            wanted = objects.values[index[row == portal - portals[0]]]
            yield Finding(_name(tables, portal), measured, f"{len(wanted)} objects {wanted[:8].tolist()}")
        for portal in np.setdiff1d(_differing((row, codes[index]), tables.switch_codes, portals), wrong):
            measured = f"codes {tables.switch_codes.row(portal)[:8].tolist()}"
            wanted = codes[index[row == portal - portals[0]]]
            yield Finding(_name(tables, portal), measured, f"{wanted[:8].tolist()}, those of the target")

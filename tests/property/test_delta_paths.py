"""Random sets on random graphs: deltas along random paths, cycles included, end in the exact state."""

from __future__ import annotations

import hashlib

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.lod.model import LodSettings, LodTable
from tilesnav_ref.stream.state import Delta, State, apply_delta
from tilesnav_ref.tileset.delta import make_deltas, state_digests
from tilesnav_ref.tileset.model import DeltaTable
from tilesnav_ref.visibility.model import PvsTable


def _offsets(rows: list[list[int]]) -> np.ndarray:
    return np.concatenate(([0], np.cumsum([len(row) for row in rows], dtype=np.int64)))


def _graph(cell_count: int, edges: set[tuple[int, int]]) -> CellComplex:
    both_ways = edges | {(b, a) for a, b in edges}
    rows = [sorted(b for a, b in both_ways if a == i) for i in range(cell_count)]
    numbers = {edge: k for k, edge in enumerate(sorted(edges))}
    polygons = [numbers[min(i, j), max(i, j)] for i, row in enumerate(rows) for j in row]
    boxes = np.arange(cell_count, dtype=np.int64)[:, None] * np.array([1, 0, 0])
    return CellComplex(
        lower=boxes,
        upper=boxes + 1,
        kinds=np.zeros(cell_count, dtype=np.uint8),
        portal_offsets=_offsets(rows),
        portal_targets=np.array([j for row in rows for j in row], dtype=np.int64),
        portal_polygons=np.array(polygons, dtype=np.int64),
        clearance=0,
        coverage=1.0,
    )


@st.composite
def _maps(draw: st.DrawFn) -> tuple[CellComplex, PvsTable, LodTable, np.ndarray]:
    cell_count = draw(st.integers(1, 6))
    pairs = [(i, j) for i in range(cell_count) for j in range(i + 1, cell_count)]
    edges = draw(st.sets(st.sampled_from(pairs))) if pairs else set()
    object_offsets = _offsets([[0] * n for n in draw(st.lists(st.integers(1, 5), min_size=1, max_size=6))])
    face_count = int(object_offsets[-1])
    sets = [sorted(draw(st.sets(st.integers(0, face_count - 1)))) for _ in range(cell_count)]
    owners = [np.unique(np.searchsorted(object_offsets, row, side="right") - 1).tolist() for row in sets]
    codes = [draw(st.lists(st.integers(0, 255), min_size=len(row), max_size=len(row))) for row in owners]
    flat = [f for row in sets for f in row]
    pvs = PvsTable(_offsets(sets), np.array(flat, dtype=np.uint32), np.zeros(len(flat), dtype=np.bool_))
    lod = LodTable(
        LodSettings(level_count=256),
        _offsets(owners),
        np.array([o for row in owners for o in row], dtype=np.uint32),
        np.array([c for row in codes for c in row], dtype=np.uint8),
    )
    return _graph(cell_count, edges), pvs, lod, object_offsets


def _delta_of(deltas: DeltaTable, portal: int) -> Delta:
    entered = deltas.entered[deltas.entered_offsets[portal] : deltas.entered_offsets[portal + 1]]
    left = deltas.left[deltas.left_offsets[portal] : deltas.left_offsets[portal + 1]]
    switches = slice(deltas.switch_offsets[portal], deltas.switch_offsets[portal + 1])
    return Delta(entered, left, deltas.switch_objects[switches], deltas.switch_codes[switches])


def _state_of(pvs: PvsTable, lod: LodTable, cell: int) -> State:
    levels = slice(lod.lod_offsets[cell], lod.lod_offsets[cell + 1])
    return State(pvs.faces_of(cell), lod.lod_objects[levels], lod.lod_codes[levels])


@settings(max_examples=150, deadline=None)
@given(_maps(), st.data())
def test_any_path_ends_in_the_exact_state(
    one: tuple[CellComplex, PvsTable, LodTable, np.ndarray], data: st.DataObject
) -> None:
    cells, pvs, lod, object_offsets = one
    deltas, digests = make_deltas(cells, pvs, lod), state_digests(pvs, lod)
    cell = data.draw(st.integers(0, cells.count - 1))
    state = _state_of(pvs, lod, cell)
    for turn in data.draw(st.lists(st.integers(0, 5), max_size=20)):
        first, last = cells.portal_offsets[cell], cells.portal_offsets[cell + 1]
        if first == last:
            break
        portal = int(first + turn % (last - first))
        state = apply_delta(state, _delta_of(deltas, portal), object_offsets)
        cell = int(cells.portal_targets[portal])
        expected = _state_of(pvs, lod, cell)
        assert state.faces.tolist() == expected.faces.tolist()
        assert state.objects.tolist() == expected.objects.tolist()
        assert state.codes.tolist() == expected.codes.tolist()
        assert state.digest() == digests[cell].tobytes()
        assert hashlib.sha256(state.canonical_bytes()).digest() == state.digest()


@settings(max_examples=150, deadline=None)
@given(_maps())
def test_deltas_are_the_set_differences(one: tuple[CellComplex, PvsTable, LodTable, np.ndarray]) -> None:
    cells, pvs, lod, _ = one
    deltas = make_deltas(cells, pvs, lod)
    sources = np.repeat(np.arange(cells.count), np.diff(cells.portal_offsets))
    for portal, (a, b) in enumerate(zip(sources, cells.portal_targets, strict=True)):
        delta, before, after = _delta_of(deltas, portal), _state_of(pvs, lod, a), _state_of(pvs, lod, b)
        old_faces, new_faces = set(before.faces.tolist()), set(after.faces.tolist())
        assert delta.entered.tolist() == sorted(new_faces - old_faces)
        assert delta.left.tolist() == sorted(old_faces - new_faces)
        old_levels = dict(zip(before.objects.tolist(), before.codes.tolist(), strict=True))
        new_levels = dict(zip(after.objects.tolist(), after.codes.tolist(), strict=True))
        switched = dict(zip(delta.switch_objects.tolist(), delta.switch_codes.tolist(), strict=True))
        assert switched == {o: c for o, c in new_levels.items() if old_levels.get(o) != c}
        assert delta.switch_objects.tolist() == sorted(switched)

"""States of the cells, and the tables of the nav files that follow from them."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casebuilder.exact import world_pvs
from casebuilder.metric import level_code
from casebuilder.world import Cell, World

Tables = dict[str, NDArray[Any]]
"""Tables of a nav file by group and member, such as pvs.faces."""

COUNTS = {
    "portals.count": "portals.targets",
    "pvs.count": "pvs.faces",
    "lod.count": "lod.objects",
    "deltas.enteredCount": "deltas.entered",
    "deltas.leftCount": "deltas.left",
    "deltas.switchCount": "deltas.switchObjects",
}
"""Member that counts the elements of a table."""


@dataclass
class State:
    """What a vehicle in a cell holds."""

    faces: list[int]
    proven: int
    codes: dict[int, int]
    """Level code of every object listed."""

    def canonical(self) -> bytes:
        """Canonical bytes of the state."""
        objects = list(self.codes)
        return struct.pack(
            f"<I{len(self.faces)}II{len(objects)}I{len(objects)}B",
            len(self.faces),
            *self.faces,
            len(objects),
            *objects,
            *self.codes.values(),
        )


def object_codes(world: World, cell: Cell, faces: list[int]) -> dict[int, int]:
    """Level codes of the objects that have one of the faces."""
    owner, triangles = world.face_object, world.faces
    codes = {}
    for number in sorted({owner[f] for f in faces}):
        mine = tuple(triangles[f] for f in faces if owner[f] == number)
        codes[number] = level_code(cell, world.exponent, mine, world.lod)
    return codes


def world_states(world: World) -> list[State]:
    """State of every cell, with all visible faces proven and no other listed."""
    pvs = world_pvs(world)
    return [
        State(faces, len(faces), object_codes(world, cell, faces))
        for cell, faces in zip(world.cells, pvs, strict=True)
    ]


def lower_pvs(world: World, states: list[State], cell: int, face: int) -> None:
    """Drop a face from the PVS of a cell, and make everything else of the state fit."""
    state = states[cell]
    state.faces.remove(face)
    state.proven -= 1
    state.codes = object_codes(world, world.cells[cell], state.faces)


def _ragged(lists: list[list[int]]) -> tuple[NDArray[Any], NDArray[Any]]:
    offsets = np.cumsum([0, *map(len, lists)]).astype("<u4")
    return offsets, np.array([v for part in lists for v in part], dtype="<u4")


def _polygons(world: World, directed: list[tuple[int, int, int]]) -> tuple[list[int], Tables]:
    used = sorted({polygon for _, _, polygon in directed})
    vertices = [world.portals[p].polygon for p in used]
    offsets = np.cumsum([0, *map(len, vertices)]).astype("<u4")
    flat = np.array([v for polygon in vertices for v in polygon], dtype="<f8").reshape(-1, 3)
    return used, {"portals.polygonOffsets": offsets, "portals.vertices": flat}


def _delta_tables(directed: list[tuple[int, int, int]], states: list[State]) -> Tables:
    entered, left, switched, codes = [], [], [], []
    for source, target, _ in directed:
        a, b = states[source], states[target]
        entered.append(sorted(set(b.faces) - set(a.faces)))
        left.append(sorted(set(a.faces) - set(b.faces)))
        changed = [o for o in b.codes if a.codes.get(o) != b.codes[o]]
        switched.append(changed)
        codes += [b.codes[o] for o in changed]
    tables: Tables = {}
    tables["deltas.enteredOffsets"], tables["deltas.entered"] = _ragged(entered)
    tables["deltas.leftOffsets"], tables["deltas.left"] = _ragged(left)
    tables["deltas.switchOffsets"], tables["deltas.switchObjects"] = _ragged(switched)
    tables["deltas.switchCodes"] = np.array(codes, dtype="u1")
    return tables


def sector_tables(world: World, states: list[State], sector: int) -> Tables:
    """All tables of one nav file."""
    first, count = world.sectors[sector]
    cells = range(first, first + count)
    both = [(p.cells[i], p.cells[1 - i], n) for n, p in enumerate(world.portals) for i in (0, 1)]
    directed = sorted(d for d in both if d[0] in cells)
    used, polygons = _polygons(world, directed)
    mine = [states[c] for c in cells]
    pvs_offsets, pvs_faces = _ragged([s.faces for s in mine])
    lod_offsets, lod_objects = _ragged([list(s.codes) for s in mine])
    digests = b"".join(hashlib.sha256(s.canonical()).digest() for s in mine)
    portal_offsets, targets = _ragged([[t for c, t, _ in directed if c == cell] for cell in cells])
    return {
        "cells.planes": np.array([world.cells[c].planes for c in cells], dtype="<f8"),
        "cells.kinds": np.array([world.cells[c].kind for c in cells], dtype="u1"),
        "portals.offsets": portal_offsets,
        "portals.targets": targets,
        "portals.polygons": np.array([used.index(n) for _, _, n in directed], dtype="<u4"),
        **polygons,
        "pvs.offsets": pvs_offsets,
        "pvs.faces": pvs_faces,
        "pvs.provenVisible": np.array([s.proven for s in mine], dtype="<u4"),
        "pvs.digests": np.frombuffer(digests, dtype="u1"),
        "lod.offsets": lod_offsets,
        "lod.objects": lod_objects,
        "lod.codes": np.array([c for s in mine for c in s.codes.values()], dtype="u1"),
        **_delta_tables(directed, states),
    }

"""Certificate files, from arguments that are known to hold.

Each hidden face of these scenes is hidden by a convex polygon between, or lies on the far side of a solid
(exact.py). In the first case the faces of the polygon are the occluder: its border is that of the polygon,
which no segment reaches. In the second they are all other faces of the solid: the border is that of the
facet, in the plane of the target, which no segment meets before its end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import accumulate
from math import ceil, floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casebuilder.container import container_bytes, padded
from casebuilder.exact import behind_solid, blocked_by, cell_corners
from casebuilder.state import State
from casebuilder.world import Cell, World

Json = dict[str, Any]
Region = tuple[int, ...]
"""Lower and upper corner in units, that of a prism where its run axis begins."""

COUNTS = {
    "useCount": "uses",
    "targetCount": "targets",
    "cutCount": "cuts",
    "leafCount": "leaves",
    "occluderFaceCount": "occluders",
}
"""Member that counts the elements of a table."""


@dataclass
class Proof:
    """A certificate: region, targets, codes of the tree, and for each leaf the faces of its occluder."""

    region: Region
    targets: list[int]
    occluders: list[list[int]]
    cuts: list[int] = field(default_factory=lambda: [0])
    slant: tuple[int, int, int] = (0, 0, 0)
    """p, q and the shape of the region."""


@dataclass
class Proofs:
    """Certificates of a sector, and for each cell which it uses."""

    sector: tuple[int, int]
    uses: list[list[int]]
    certificates: list[Proof]
    origin: tuple[int, int, int] = (0, 0, 0)
    subdivision: int = 0
    changes: dict[str, Any] = field(default_factory=dict)
    """Tables that are written in place of what they should be, or functions that change them."""


Maker = Callable[[World, list[State]], dict[int, Proofs]]
"""Makes the certificate files of a case, by the number of the sector."""


def occluder_of(world: World, cell: Cell, number: int) -> list[int]:
    """Faces that hide a face from a cell."""
    corners = cell_corners(cell, world.exponent)
    parts = [(item, shape) for item in world.objects for shape in item.shapes]
    ends = list(accumulate(len(shape.triangles) for _, shape in parts))
    faces = [
        list(range(end - len(shape.triangles), end)) for (_, shape), end in zip(parts, ends, strict=True)
    ]
    of_parts = list(zip(parts, faces, strict=True))
    owner, shape = next(part for part, numbers in of_parts if number in numbers)
    if owner.closed and behind_solid(owner, shape, corners):
        others = [numbers for (item, other), numbers in of_parts if item is owner and other is not shape]
        return [face for numbers in others for face in numbers]
    face = world.faces[number]
    for (item, other), numbers in of_parts:
        if item.porous or not other.outline or other is shape:
            continue
        if blocked_by(other.outline, corners, face):
            return numbers
    raise ValueError(f"face {number} is hidden by nothing that is known")


def region_of(cells: tuple[Cell, ...], proofs: Proofs, exponent: int) -> Region:
    """Smallest region that holds cells."""
    corners = [c for cell in cells for c in cell_corners(cell, exponent)]
    scale = 2**proofs.subdivision
    units = [[(c[k] - proofs.origin[k]) * scale for c in corners] for k in range(3)]
    return (*(floor(min(axis)) for axis in units), *(ceil(max(axis)) for axis in units))


def one_each(world: World, states: list[State], sector: int, **frame: Any) -> Proofs:
    """A certificate for each cell of a sector and each face that it does not list."""
    first, count = world.sectors[sector]
    proofs = Proofs((first, count), [], [], **frame)
    for cell in range(first, first + count):
        region = region_of((world.cells[cell],), proofs, world.exponent)
        hidden = sorted(set(range(len(world.faces))) - set(states[cell].faces))
        start = len(proofs.certificates)
        for face in hidden:
            occluder = occluder_of(world, world.cells[cell], face)
            proofs.certificates.append(Proof(region, [face], [occluder]))
        proofs.uses.append(list(range(start, start + len(hidden))))
    return proofs


def _ragged(lists: list[list[int]]) -> tuple[NDArray[Any], NDArray[Any]]:
    values = [value for part in lists for value in part]
    return np.cumsum([0, *map(len, lists)]).astype("<u4"), np.array(values, dtype="<u4")


def proof_tables(proofs: Proofs) -> dict[str, NDArray[Any]]:
    """Tables of a certificate file by member; equal occluders are written once."""
    used = [tuple(occluder) for proof in proofs.certificates for occluder in proof.occluders]
    occluders = list(dict.fromkeys(used))
    tables: dict[str, NDArray[Any]] = {}
    tables["cellOffsets"], tables["uses"] = _ragged(proofs.uses)
    rows = [(*proof.region, *proof.slant) for proof in proofs.certificates]
    numbers = np.array(rows, dtype="<i4").reshape(-1, 9)
    tables["regions"], tables["shapes"] = numbers[:, :8].copy(), numbers[:, 8].astype("u1")
    tables["targetOffsets"], tables["targets"] = _ragged([proof.targets for proof in proofs.certificates])
    tables["cutOffsets"], cuts = _ragged([proof.cuts for proof in proofs.certificates])
    tables["cuts"] = cuts.astype("u1")
    tables["leaves"] = np.array([occluders.index(occluder) for occluder in used], dtype="<u4")
    tables["occluderOffsets"], tables["occluders"] = _ragged([list(occluder) for occluder in occluders])
    for name, change in proofs.changes.items():
        tables[name] = change(tables[name])
    return tables


def proof_parts(proofs: Proofs) -> tuple[Json, bytes]:
    """JSON part and unpadded binary part of a certificate file."""
    views: list[Json] = []
    tables = proof_tables(proofs)
    group: Json = {"count": len(tables["regions"])}
    group |= {member: len(tables[table]) for member, table in COUNTS.items()}
    group["occluderCount"] = len(tables["occluderOffsets"]) - 1
    binary = b""
    for name, table in tables.items():
        binary = padded(binary, b"\0", 8)
        group[name] = len(views)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": table.nbytes})
        binary += table.tobytes()
    part = {
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "sector": {"firstCell": proofs.sector[0], "cellCount": proofs.sector[1]},
        "frame": {"origin": list(proofs.origin), "subdivision": proofs.subdivision},
        "certificates": group,
    }
    return part, binary


def proof_bytes(part: Json | bytes, binary: bytes) -> bytes:
    """Certificate file of a JSON part, which may be given as bytes, and a binary part."""
    return container_bytes(b"cert", part, binary)

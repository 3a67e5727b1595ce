"""The small tileset with a sheet behind its wall, and a certificate file packed by hand.

The sheet (object 3, faces 5 and 6) stands in the plane x = 6, -0.5 <= y <= 0.5, 1 <= z <= 2. From both cells
the wall, faces 2 and 3, hides it. Units are grid steps of 2^-10 m.
"""

from __future__ import annotations

import hashlib
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from validator_fixture import FLAT, FLOOR, WALL, Small

from tilesnav_validator.certfile import Certificates
from tilesnav_validator.proofs import Scene, batches, faults
from tilesnav_validator.subject import Faces
from tilesnav_validator.tables import Ragged

SHEET = [[(6, -0.5, 1), (6, 0.5, 1), (6, 0.5, 2)], [(6, -0.5, 1), (6, 0.5, 2), (6, -0.5, 2)]]
REGION = [-4096, -2048, 1024, 3072, 2048, 3072, 0, 0]
"""Holds both cells."""

TYPES = {"regions": "<i4", "shapes": "u1", "cuts": "u1"}
COUNTED = {
    "count": "regions",
    "useCount": "uses",
    "targetCount": "targets",
    "cutCount": "cuts",
    "leafCount": "leaves",
    "occluderCount": "occluderOffsets",
    "occluderFaceCount": "occluders",
}


def tables() -> dict[str, list[Any]]:
    """A certificate for each face of the sheet, the second with a cut, both used by both cells."""
    return {
        "cellOffsets": [0, 2, 4],
        "uses": [0, 1, 0, 1],
        "regions": [REGION, REGION],
        "shapes": [0, 0],
        "targetOffsets": [0, 1, 2],
        "targets": [5, 6],
        "cutOffsets": [0, 1, 4],
        "cuts": [0, 1, 0, 0],
        "leaves": [0, 0, 0],
        "occluderOffsets": [0, 2],
        "occluders": [2, 3],
    }


def pack(members: dict[str, list[Any]]) -> bytes:
    """A certificate file of its tables."""
    group: dict[str, int] = {}
    views: list[dict[str, int]] = []
    binary = b""
    for name, values in members.items():
        data = np.array(values, dtype=TYPES.get(name, "<u4")).tobytes()
        binary += b"\0" * (-len(binary) % 8)
        group[name] = len(views)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data
    for count, table in COUNTED.items():
        group[count] = len(members[table]) - (table == "occluderOffsets")
    root = {
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "sector": {"firstCell": 0, "cellCount": 2},
        "frame": {"origin": [0, 0, 0], "subdivision": 0},
        "certificates": group,
    }
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 8)
    binary += b"\0" * (-len(binary) % 8)
    return struct.pack("<4sIQQ", b"cert", 1, len(text), len(binary)) + text + binary


class Proven(Small):
    """The small tileset with its sheet and certificates; change ``members``, or ``cert``, then write it."""

    def __init__(self) -> None:
        super().__init__(objects=[FLOOR, WALL, FLAT, SHEET])
        self.members = tables()
        self.cert: bytes | None = None
        self.extension |= {"faceCount": 7, "objectCount": 4}
        self.root["content"]["extensions"]["3DTILES_nav"] |= {"faceCount": 7, "objectCount": 4}

    def write(self, folder: Path) -> Path:
        """Write the files; return the path of the entry tileset."""
        cert = pack(self.members) if self.cert is None else self.cert
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "0.cert").write_bytes(cert)
        digest = hashlib.sha256(cert).hexdigest()
        self.extension["sectors"][0]["certificates"] = {"uri": "0.cert", "sha256": digest}
        return super().write(folder)


def box_triangles(low: tuple[int, ...], high: tuple[int, ...]) -> list[list[tuple[int, ...]]]:
    """The twelve triangles of a box."""
    corners = [tuple((low, high)[(i >> k) & 1][k] for k in range(3)) for i in range(8)]
    quads = ((0, 2, 6, 4), (1, 3, 7, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 1, 3, 2), (4, 5, 7, 6))
    return [[corners[i] for i in part] for a, b, c, d in quads for part in ((a, b, c), (a, c, d))]


def one_certificate(
    triangles: Any,
    region: list[int],
    targets: list[int],
    occluders: list[list[int]],
    cuts: tuple[int, ...] = (0,),
) -> Scene:
    """The scene of one certificate whose leaves have the occluders one after the other; a unit is a step.

    The region is a box of six numbers, or a prism of eight and its shape.
    """
    row = np.array([*region, 0, 0, 0][:9], dtype=np.int64)
    grid = np.array(triangles, dtype=np.int64).reshape(-1, 3, 3)
    ends = np.cumsum([0, *map(len, occluders)])
    found = Certificates(
        name="x",
        first_cell=0,
        origin=np.zeros(3, np.int64),
        subdivision=0,
        uses=Ragged(np.array([0, 1]), np.array([0])),
        regions=row[None, :8],
        shapes=row[8:],
        targets=Ragged(np.array([0, len(targets)]), np.array(targets, dtype=np.int64)),
        cuts=Ragged(np.array([0, len(cuts)]), np.array(cuts, dtype=np.uint8)),
        leaves=np.arange(len(occluders)),
        occluders=Ragged(ends, np.array([f for part in occluders for f in part], dtype=np.int64)),
    )
    return Scene(found, Faces(grid, grid.astype(np.float64), np.zeros(len(grid), np.int64)))


def complaints(scene: Scene) -> list[str]:
    """What is held against the leaves of a scene."""
    random = np.random.default_rng(0)
    return [finding.measured for batch in batches(scene) for finding in faults(scene, batch, random)]

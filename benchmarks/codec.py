"""Bytes a face of packet bodies beside Draco, meshopt and general codecs of the same faces, in one run.

Usage: python benchmarks/codec.py [SCENE] [--errors 0.25,0.6] [--boxes N] [--rays N] [--tileset FOLDER]

Bodies hold everything: which objects, which faces leave, the numbers and the geometry of those that enter.
The others are given the geometry of the entering faces alone, in an order that suits them. Small bodies are
made of the faces that rays from neighbouring boxes in a street meet, or, with `--tileset`, of the sets of its
cells along portals. Needs the extra `tiles` for Draco and meshopt. No test asserts a time.
"""

from __future__ import annotations

import argparse
import lzma
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from time import process_time

import DracoPy
import meshopt
import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray
from scenes import TOWN, load

from tilesnav_ref.levels import LevelSettings, coarse_levels
from tilesnav_ref.packet.geometry import decode_body, encode_body
from tilesnav_ref.packet.geometry_order import canonical, order_of, places_of
from tilesnav_ref.packet.model import ObjectFaces
from tilesnav_ref.scene import Scene
from tilesnav_ref.stream.reader import open_tileset

Parts = tuple[ObjectFaces, ...]
BOX = np.array((8.0, 8.0, 3.0))
"""Metres; edges of the boxes that rays start from."""
BATCH = 100_000
"""Rays at a time."""
REPEATS = 3


@dataclass
class Tally:
    """Sums of one codec."""

    size: int = 0
    seconds: list[float] = field(default_factory=list)


def parts_of(scene: Scene, chosen: NDArray[np.int64], level: int = 0) -> Parts:
    """Some faces of a scene, object by object."""
    first = np.searchsorted(scene.face_object, np.arange(scene.object_count + 1))
    corners = canonical(scene.corners()[chosen].astype(np.int32))
    objects = scene.face_object[chosen]
    rows = [(int(k), objects == k) for k in np.unique(objects)]
    numbers = [(chosen[of] - first[k]).astype(np.uint32) for k, of in rows]
    return tuple(
        ObjectFaces(k, level, 0, faces, corners[of]) for (k, of), faces in zip(rows, numbers, strict=True)
    )


def along_the_curve(parts: Parts) -> Parts:
    """The same faces numbered in the order of space."""
    return tuple(
        ObjectFaces(p.object, p.level, p.flags, p.faces, p.corners[order_of(p.corners, places_of(p.corners))])
        for p in parts
    )


def entering(before: Parts, after: Parts) -> NDArray[np.int32]:
    """(F, 3, 3) corners of the faces that enter."""
    held = {p.object: p.faces for p in before}
    none = np.zeros(0, np.uint32)
    return np.concatenate([p.corners[~np.isin(p.faces, held.get(p.object, none))] for p in after])


def views(scene: Scene, boxes: int, rays: int) -> list[Parts]:
    """Faces that rays from boxes in a row meet, 2 m above the ground, along the middle of the scene."""
    world = rtcore_scene.EmbreeScene()
    TriangleMesh(world, (scene.vertices * scene.step).astype(np.float32)[scene.faces])
    generator = np.random.default_rng(1)
    found = []
    for i in range(boxes):
        seen = np.zeros(scene.face_count, bool)
        centre = np.array(((i - boxes / 2) * BOX[0], 0.0, 2.0))
        for _ in range(max(rays // BATCH, 1)):
            origins = centre + (generator.random((BATCH, 3)) - 0.5) * BOX
            directions = generator.normal(size=(BATCH, 3))
            hit = world.run(origins.astype(np.float32), directions.astype(np.float32))
            seen[hit[hit >= 0]] = True
        found.append(parts_of(scene, np.flatnonzero(seen)))
    return found


def tileset_pairs(folder: Path, number: int) -> list[tuple[Parts, Parts]]:
    """Sets of neighbouring cells of a tileset, finest level, along portals spread over it."""
    tileset = open_tileset(folder)
    own = [i for i, one in enumerate(tileset.contents) if getattr(one, "level", 0) == 0]
    corners = np.concatenate([tileset.corners(i) for i in own]).astype(np.float64) / tileset.step
    grid, firsts = canonical(np.rint(corners).astype(np.int32)), tileset.object_offsets

    def parts(cell: int) -> Parts:
        faces = tileset.state(cell).faces.astype(np.int64)
        objects = np.searchsorted(firsts, faces, side="right") - 1
        rows = [(int(k), faces[objects == k]) for k in np.unique(objects)]
        return tuple(ObjectFaces(k, 0, 0, (of - firsts[k]).astype(np.uint32), grid[of]) for k, of in rows)

    cells = range(0, tileset.cell_count, max(tileset.cell_count // number, 1))
    pairs = [(cell, tileset.neighbours(cell)) for cell in cells]
    return [(parts(cell), parts(int(to[0]))) for cell, to in pairs if len(to)]


def indexed(corners: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.uint32]]:
    """Distinct vertices and the faces between them, both in the order of first use."""
    flat = corners.reshape(-1, 3)
    unique, first, inverse = np.unique(flat, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(unique), np.int64)
    rank[np.argsort(first)] = np.arange(len(unique))
    return flat[np.sort(first)], rank[inverse.reshape(-1)].astype(np.uint32).reshape(-1, 3)


def draco(corners: NDArray[np.int32]) -> tuple[bytes, Callable[[bytes], object]]:
    """Draco at its best level, on exactly this grid."""
    vertices, faces = indexed(corners)
    lower = vertices.min(axis=0)
    bits = max(int(np.ptp(vertices, axis=0).max()).bit_length(), 1)
    data = DracoPy.encode(
        (vertices - lower).astype(np.float64), faces, quantization_bits=bits, compression_level=10,
        quantization_range=float((1 << bits) - 1), quantization_origin=[0.0, 0.0, 0.0],
    )  # fmt: skip
    return data, DracoPy.decode


def meshopt_lzma(corners: NDArray[np.int32]) -> tuple[bytes, Callable[[bytes], object]]:
    """Meshopt's codecs of vertices (padded to 12 bytes) and of triangles, then LZMA."""
    vertices, faces = indexed(corners)
    vertices = np.ascontiguousarray(vertices - vertices.min(axis=0))
    first = bytes(meshopt.encode_vertex_buffer(vertices))
    second = bytes(meshopt.encode_index_buffer(faces.reshape(-1)))
    data = packed(first + second)
    count, size = len(vertices), vertices.itemsize * 3

    def decode(packet: bytes) -> object:
        raw = unpacked(packet)
        meshopt.decode_index_buffer(raw[len(first) :], faces.size, 4)
        return meshopt.decode_vertex_buffer(raw[: len(first)], count, size)

    return data, decode


def packed(data: bytes) -> bytes:
    """LZMA without container."""
    return lzma.compress(data, lzma.FORMAT_RAW, filters=[{"id": lzma.FILTER_LZMA2, "preset": 9}])


def unpacked(data: bytes) -> bytes:
    """Undo `packed`."""
    return lzma.decompress(data, lzma.FORMAT_RAW, filters=[{"id": lzma.FILTER_LZMA2, "preset": 9}])


def planes(corners: NDArray[np.int32]) -> bytes:
    """Differences of vertices and of indices, byte plane by byte plane."""
    vertices, faces = indexed(corners)
    steps = np.diff(vertices, axis=0, prepend=0).astype(np.int32)
    turns = np.diff(faces.reshape(-1).astype(np.int32), prepend=0).astype(np.int32)
    zigzag = [(a << 1) ^ (a >> 31) for a in (*steps.T, turns)]
    return b"".join(a.astype("<u4").view(np.uint8).reshape(-1, 4).T.tobytes() for a in zigzag)


def peers(corners: NDArray[np.int32]) -> dict[str, tuple[bytes, Callable[[bytes], object]]]:
    """What others make of the same faces."""
    raw = planes(corners)
    found: dict[str, tuple[bytes, Callable[[bytes], object]]] = {
        "differences, zlib 9": (zlib.compress(raw, 9), zlib.decompress),
        "differences, LZMA": (packed(raw), unpacked),
        "Draco, level 10": draco(corners),
    }
    return found | {"meshopt, LZMA": meshopt_lzma(corners)}


def measure(name: str, pairs: list[tuple[Parts, Parts]]) -> None:
    """Print a row for each codec."""
    tallies: dict[str, Tally] = {}
    entered = [entering(before, after) for before, after in pairs]
    pairs = [pair for pair, corners in zip(pairs, entered, strict=True) if len(corners)]
    entered = [corners for corners in entered if len(corners)]
    for (before, after), corners in zip(pairs, entered, strict=True):
        body = encode_body(before, after)
        rows = {"this codec, all in": (body, lambda data, before=before: decode_body(data, before))}
        for label, (data, decode) in (rows | peers(corners)).items():
            tally = tallies.setdefault(label, Tally())
            tally.size += len(data)
            decode(data)
            start = process_time()
            for _ in range(REPEATS):
                decode(data)
            tally.seconds.append((process_time() - start) / REPEATS)
    total = sum(len(corners) for corners in entered)
    for label, tally in tallies.items():
        mean = tally.size / total
        decoding = np.median(tally.seconds) * 1e3
        print(f"| {name} | {len(pairs)} | {total:,} | {label} | {mean:.3f} | {decoding:.1f} |", flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default=TOWN)
    parser.add_argument("--errors", default="0.25,0.6", help="of coarse levels, m; empty: none")
    parser.add_argument("--boxes", type=int, default=12, help="boxes in a row that packets are made of")
    parser.add_argument("--rays", type=int, default=2_000_000, help="rays from each box")
    parser.add_argument("--tileset", type=Path, help="take packets from the sets of its cells")
    parser.add_argument("--packets", type=int, default=40, help="of a tileset, at most")
    arguments = parser.parse_args()
    columns = ("what", "bodies", "faces that enter", "codec", "bytes a face", "decode, CPU ms, median")
    print(f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    if arguments.tileset:
        measure("neighbouring cells", tileset_pairs(arguments.tileset, arguments.packets))
        return
    scene = load(arguments.scene, None)
    measure("whole scene", [((), parts_of(scene, np.arange(scene.face_count)))])
    errors = tuple(float(one) for one in arguments.errors.split(",") if one)
    levels = coarse_levels(scene, LevelSettings(1 + len(errors), errors)) if errors else ()
    for one in levels:
        whole = parts_of(one.scene, np.arange(one.scene.face_count), one.level)
        measure(f"level {one.level}", [((), whole)])
        measure(f"level {one.level}, numbered along the curve", [((), along_the_curve(whole))])
    seen = views(scene, arguments.boxes, arguments.rays)
    measure("key frames", [((), one) for one in seen])
    measure("from box to box", list(pairwise(seen)))


if __name__ == "__main__":
    main()

"""Judging the leaves of certificates by the conditions of the parity theorem, many at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import cuttrees, parity, prisms, separation, shafts
from tilesnav_validator.certfile import Certificates
from tilesnav_validator.findings import Finding
from tilesnav_validator.ragged import take
from tilesnav_validator.subject import Faces

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

LEAVES = 2**12
"""Leaves that are judged together."""

PAIRS = 2**17
"""Pairs of a leaf and a face of its occluder that are judged together; one leaf alone may have more."""


@dataclass(frozen=True)
class Batch:
    """Leaves that are judged together.

    Attributes
    ----------
    number : ndarray of int64, shape (k,)
        Their numbers in the file.
    certificate : ndarray of int64, shape (k,)
        Certificates that they belong to: all with one target, or all with several.
    parts : shafts.Parts
    """

    number: IntArray
    certificate: IntArray
    parts: shafts.Parts


class Scene:
    """The faces in the units of a certificate file.

    Parameters
    ----------
    found : Certificates
    faces : Faces
    """

    def __init__(self, found: Certificates, faces: Faces) -> None:
        self.found = found
        self.faces = faces

    def corners(self, face: IntArray) -> IntArray:
        """Corners of faces in units, shape (k, 3, 3)."""
        return self.found.in_units(self.faces.grid[face])

    @cached_property
    def first_leaf(self) -> IntArray:
        """Number of the first leaf of each certificate, and of all leaves, from the codes; shape (p + 1,)."""
        before = np.concatenate([[0], np.cumsum(self.found.cuts.values == cuttrees.LEAF)])
        return np.asarray(before[self.found.cuts.offsets], dtype=np.int64)

    @cached_property
    def single(self) -> BoolArray:
        """Certificates with one target."""
        return np.asarray(np.diff(self.found.targets.offsets) == 1)

    @cached_property
    def is_leaf(self) -> BoolArray:
        """Certificates whose tree is one leaf."""
        first = np.append(self.found.cuts.values, cuttrees.LEAF)[self.found.cuts.offsets[:-1]]
        return np.asarray((np.diff(self.found.cuts.offsets) == 1) & (first == cuttrees.LEAF))

    @cached_property
    def target_boxes(self) -> IntArray:
        """Closed boxes spanned by the targets of each certificate, shape (p, 2, 3)."""
        corners = self.corners(self.found.targets.values)
        starts = self.found.targets.offsets[:-1]
        low = np.minimum.reduceat(corners.min(axis=1), starts, axis=0)
        high = np.maximum.reduceat(corners.max(axis=1), starts, axis=0)
        return np.stack([low, high], axis=1)

    def triangle(self, certificate: int) -> cuttrees.Numbers:
        """Corners of the one target; nothing where there are several."""
        if not self.single[certificate]:
            return ()
        start = self.found.targets.offsets[certificate]
        return tuple(self.corners(self.found.targets.values[start : start + 1]).ravel().tolist())

    def tree(self, certificate: int) -> Iterator[tuple[cuttrees.Numbers, cuttrees.Numbers]]:
        """Parts of the leaves of a certificate; raises ``TreeError`` where its codes are no tree."""
        shape = int(self.found.shapes[certificate])
        region = prisms.filled(self.found.regions[certificate].tolist(), shape)
        codes = self.found.cuts.row(certificate).tobytes()
        return cuttrees.leaves(codes, region, shape, self.triangle(certificate))


def batches(scene: Scene) -> Iterator[Batch]:
    """All leaves; the trees must have been checked."""
    for kind in (scene.single & scene.is_leaf, ~scene.single):
        chosen = np.flatnonzero(kind)
        for first in range(0, len(chosen), LEAVES):
            yield _uncut(scene, chosen[first : first + LEAVES])
    yield from _cut(scene, np.flatnonzero(~scene.is_leaf))


def _uncut(scene: Scene, chosen: IntArray) -> Batch:
    """Certificates of one leaf each, all with one target or all with several."""
    if scene.single[chosen[0]]:
        faces = scene.found.targets.values[scene.found.targets.offsets[chosen]]
        target = scene.corners(faces)
    else:
        boxes = scene.target_boxes[chosen]
        target = prisms.box_corners(boxes[:, 0], boxes[:, 1])
    return Batch(scene.first_leaf[chosen], chosen, shafts.Parts(scene.found.corners(chosen), target))


def _cut(scene: Scene, chosen: IntArray) -> Iterator[Batch]:
    """Leaves of the trees of certificates with one target."""
    waiting: list[tuple[int, ...]] = []
    for certificate in chosen.tolist():
        number = int(scene.first_leaf[certificate])
        for part, triangle in scene.tree(certificate):
            waiting.append((number, certificate, *part, *triangle))
            number += 1
            if len(waiting) == LEAVES:
                yield _packed(scene, waiting)
                waiting = []
    if waiting:
        yield _packed(scene, waiting)


def _packed(scene: Scene, rows: list[tuple[int, ...]]) -> Batch:
    table = np.array(rows, dtype=np.int64)
    corners = prisms.corners(table[:, 2:10], scene.found.shapes[table[:, 1]])
    return Batch(table[:, 0], table[:, 1], shafts.Parts(corners, table[:, 10:].reshape(-1, 3, 3)))


def flat_targets(scene: Scene) -> Iterator[Finding]:
    """One finding for each certificate none of whose targets has an area."""
    area = scene.faces.sound[scene.found.targets.values]
    for index in np.flatnonzero(~np.logical_or.reduceat(area, scene.found.targets.offsets[:-1])):
        yield Finding(f"{scene.found.name} certificate {index}", "no target has an area", "one at least")


def faults(scene: Scene, batch: Batch, random: np.random.Generator) -> Iterator[Finding]:
    """One finding for each leaf of a batch that is not sound."""
    counts = np.diff(scene.found.occluders.offsets)[scene.found.leaves[batch.number]]
    group = np.cumsum(counts) // PAIRS
    for part in np.split(np.arange(len(group)), np.flatnonzero(np.diff(group)) + 1):
        yield from _group_faults(
            scene, Batch(batch.number[part], batch.certificate[part], batch.parts.take(part)), random
        )


def _group_faults(scene: Scene, batch: Batch, random: np.random.Generator) -> Iterator[Finding]:
    """The first reason against each leaf: flat or porous faces, contacts, open edges, parity."""
    occluder = scene.found.leaves[batch.number]
    leaf, index = take(scene.found.occluders.offsets, occluder)
    face = scene.found.occluders.values[index]
    certificate = batch.certificate[leaf]
    reasons: dict[int, tuple[str, str]] = {}
    tests = (
        (~scene.faces.sound[face], "has no area", "faces with an area"),
        (~scene.faces.blocking[face], "is porous", "opaque faces"),
        (_meet_regions(scene, certificate, face), "meets the region", "no contact"),
        (_meet_targets(scene, certificate, face), "meets the target", "no contact"),
    )
    for hit, verb, allowed in tests:
        for at in np.flatnonzero(hit).tolist():
            reasons.setdefault(int(leaf[at]), (f"face {face[at]} of the occluder {verb}", allowed))
    for at, between in _open_edges(scene, batch, occluder):
        reasons.setdefault(at, (f"the border edge {between}", "cleared by one of the four tests"))
    even = "no segment in general position that crosses an odd number of faces"
    for at in np.flatnonzero(~parity.odd(batch.parts, leaf, scene.corners(face), random)).tolist():
        reasons.setdefault(at, (even, "an odd number"))
    for at, reason in sorted(reasons.items()):
        where = f"{scene.found.name} certificate {batch.certificate[at]} leaf {batch.number[at]}"
        yield Finding(where, *reason)


def _meet_regions(scene: Scene, certificate: IntArray, face: IntArray) -> BoolArray:
    """Which faces meet the region of a certificate; the same pair of both is looked at once."""
    used, mine = np.unique(certificate, return_inverse=True)
    regions = np.column_stack([scene.found.shapes[used], scene.found.regions[used]])
    _, number = np.unique(regions, axis=0, return_inverse=True)
    keys = number.reshape(-1)[mine] * len(scene.faces.grid) + face
    _, one, all_of = np.unique(keys, return_index=True, return_inverse=True)
    certificate, triangles = certificate[one], scene.corners(face[one])
    box = scene.found.shapes[certificate] == 0
    region = scene.found.regions[certificate[box]]
    away = np.zeros(len(box), dtype=bool)
    away[box] = separation.keep_off_open_boxes(triangles[box], region[:, :3], region[:, 3:6])
    corners = scene.found.corners(certificate[~box])
    away[~box] = separation.keep_off_open_prisms(triangles[~box], corners)
    return np.asarray(~away[all_of])


def _meet_targets(scene: Scene, certificate: IntArray, face: IntArray) -> BoolArray:
    """Which faces meet the target of a certificate. A face that is a target does."""
    keys = certificate * len(scene.faces.grid) + face
    _, one, all_of = np.unique(keys, return_index=True, return_inverse=True)
    certificate, triangles = certificate[one], scene.corners(face[one])
    if scene.single[certificate[0]]:
        target = scene.found.targets.values[scene.found.targets.offsets[certificate]]
        away = separation.keep_off_triangles(triangles, scene.corners(target))
    else:
        box = scene.target_boxes[certificate]
        away = separation.keep_off_closed_boxes(triangles, box[:, 0], box[:, 1])
    return np.asarray(~away[all_of])


def _open_edges(scene: Scene, batch: Batch, occluder: IntArray) -> Iterator[tuple[int, list[list[int]]]]:
    """Leaves and the ends of border edges that no test clears."""
    used, mine = np.unique(occluder, return_inverse=True)
    offsets, start, end = odd_edges(scene, used)
    leaf, edge = take(offsets, mine.astype(np.int64))
    for at in shafts.open_edges(batch.parts, leaf, start[edge], end[edge]):
        yield int(leaf[at]), [start[edge[at]].tolist(), end[edge[at]].tolist()]


def odd_edges(scene: Scene, occluders: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Edges that an odd number of the faces of an occluder has.

    Parameters
    ----------
    scene : Scene
    occluders : ndarray of int64, shape (o,)

    Returns
    -------
    offsets : ndarray of int64, shape (o + 1,)
        Edges of each occluder.
    start, end : ndarray of int64, shape (e, 3)
        Ends in units.
    """
    row, index = take(scene.found.occluders.offsets, occluders)
    face = scene.found.occluders.values[index]
    numbers = scene.faces.corner_numbers[face]
    one, other = numbers.ravel(), np.roll(numbers, -1, axis=1).ravel()
    owner, low, high = np.repeat(row, 3), np.minimum(one, other), np.maximum(one, other)
    order = np.lexsort((high, low, owner))
    owner, low, high = owner[order], low[order], high[order]
    new = np.ones(len(order) + 1, dtype=bool)
    new[1:-1] = (np.diff(owner) != 0) | (np.diff(low) != 0) | (np.diff(high) != 0)
    first = np.flatnonzero(new)
    odd = first[:-1][np.diff(first) % 2 == 1]
    offsets = np.searchsorted(owner[odd], np.arange(len(occluders) + 1))
    at = order[odd]
    corners = scene.corners(face)
    start, end = corners[at // 3, at % 3], corners[at // 3, (at % 3 + 1) % 3]
    return offsets.astype(np.int64), start, end

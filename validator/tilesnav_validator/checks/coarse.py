"""Coarse contents: face maps, what stands for what, the chain of tiles, and errors."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import facemaps, glb
from tilesnav_validator.checks import check
from tilesnav_validator.checks.container import offset_faults, table_faults, view_faults
from tilesnav_validator.checks.contents import position_faults
from tilesnav_validator.distances import to_triangles
from tilesnav_validator.facemaps import Coarse, FaceMap
from tilesnav_validator.findings import Finding, Findings, NotRefuted
from tilesnav_validator.navfile import NavFile
from tilesnav_validator.ragged import rows
from tilesnav_validator.subject import Subject
from tilesnav_validator.tiles import EXTENSION, Content

PARTS = 8
"""Parts of the edges of a face between the points that are measured on it."""
RANDOM = 19
"""Further points on each face, drawn at random."""
BATCH = 2**14
"""Pairs of faces that are measured at once; with 64 points each that is some 100 MB of work space."""


@check("level/face-map-resolves", needs=("core/uri-inside", "core/content-digest"))
def face_map_resolves(subject: Subject) -> Iterator[Finding]:
    """Face maps that could not be opened, or are others than those meant."""
    _ = subject.coarse
    yield from subject.sector_faults["level/face-map-resolves"]


@check("level/content-gltf", needs=("level/face-map-resolves", "core/face-count", "core/on-grid"))
def content_gltf(subject: Subject) -> Iterator[Finding]:
    """Coarse contents that cannot be read without a decoder, or are off the grid."""
    for coarse in subject.coarse:
        assert coarse.content.data is not None
        try:
            primitives = glb.read(coarse.content.data)
        except glb.GlbError as error:
            yield Finding(f"{coarse.content.place} glTF {error.where}", error.measured, error.allowed)
        else:
            yield from position_faults(coarse.content, primitives, subject.step)


@check("level/container", needs=("level/content-gltf",))
def container(subject: Subject) -> Iterator[Finding]:
    """Header, JSON part, tables and numbers; the schema has been judged before."""
    for coarse in subject.coarse:
        yield from _container_faults(subject, coarse)


def _container_faults(subject: Subject, coarse: Coarse) -> Iterator[Finding]:
    """Faults of one file, those of a kind only where the kinds before have none."""
    file = coarse.file
    fault = file.header_fault()
    if fault:
        yield fault
        return
    for kind in (NavFile.padding_faults, view_faults, table_faults, offset_faults):
        faults = list(kind(file))
        yield from faults
        if faults:
            return
    clean = True
    for name in ("objectCount", "faceCount"):
        stated, counted = file.json["faceMap"][name], coarse.content.nav[name]
        if stated != counted:
            yield Finding(f"{file.name}#/faceMap/{name}", str(stated), f"{counted}, that of the content")
            clean = False
    if clean:
        found = facemaps.read(file)
        yield from facemaps.number_faults(found, subject.number("objectCount"), subject.number("faceCount"))


@check("level/objects-whole", needs=("level/container",))
def objects_whole(subject: Subject) -> Iterator[Finding]:
    """Numbering of the coarse contents of each level, and the objects that they stand for."""
    levels: dict[int, list[tuple[Coarse, FaceMap]]] = defaultdict(list)
    for coarse, found in zip(subject.coarse, subject.face_maps, strict=True):
        levels[int(coarse.content.nav["level"])].append((coarse, found))
    for level, members in sorted(levels.items()):
        members.sort(key=lambda member: int(member[0].content.nav["contentId"]))
        for expected, (coarse, _) in enumerate(members):
            measured = int(coarse.content.nav["contentId"])
            if measured != expected:
                where = f"{coarse.content.place}/extensions/{EXTENSION}/contentId"
                yield Finding(where, f"{measured} in level {level}", str(expected))
                break
        stood_for = np.concatenate([found.objects for _, found in members])
        times = np.bincount(stood_for, minlength=subject.number("objectCount"))
        for item in np.flatnonzero(times != 1):
            yield Finding(f"object {item} in level {level}", f"stood for {times[item]} times", "once")


@check("level/faces-covered", needs=("level/container",))
def faces_covered(subject: Subject) -> Iterator[Finding]:
    """Lists of faces against the objects that the primitives stand for."""
    for coarse, found, primitives in _members(subject):
        primitive = facemaps.primitive_of(primitives)
        row = rows(found.listed.offsets)
        for face in np.flatnonzero(np.diff(found.listed.offsets) == 0):
            yield Finding(f"{coarse.content.place} face {face}", "stands for no face", "one at least")
        of_listed = subject.faces.objects[found.listed.values]
        wanted = found.objects[primitive[row]]
        for index in np.flatnonzero(of_listed != wanted):
            where = f"{found.name} faces[{index}], face {row[index]}"
            yield Finding(where, f"a face of object {of_listed[index]}", f"of object {wanted[index]}")
        owed = np.isin(subject.faces.objects, found.objects)
        owed[found.listed.values] = False
        for face in np.flatnonzero(owed):
            where = f"{found.name} face {face} of level 0"
            yield Finding(where, "not stood for", f"by a face for object {subject.faces.objects[face]}")


def _members(subject: Subject) -> Iterator[tuple[Coarse, FaceMap, list[glb.Primitive]]]:
    yield from zip(subject.coarse, subject.face_maps, subject.coarse_primitives, strict=True)


@check("level/chain", needs=("level/container", "core/content-transform"))
def chain(subject: Subject) -> Iterator[Finding]:
    """Tiles of coarse contents: refinement, what is below, and geometric errors."""
    below: dict[str, list[Content]] = defaultdict(list)
    for content in subject.walk.contents:
        for above in islice(content.tile.chain(), 1, None):
            below[above.place].append(content)
    objects, first = {}, 0
    for content, primitives in zip(subject.finest, subject.primitives, strict=True):
        objects[content.place] = set(range(first, first + len(primitives)))
        first += len(primitives)
    for coarse, found in zip(subject.coarse, subject.face_maps, strict=True):
        finer = below[coarse.content.tile.place]
        held: set[int] = set().union(*(objects.get(content.place, set()) for content in finer))
        odd = sorted(held ^ set(found.objects.tolist()))
        if odd:
            measured = f"objects {odd[:8]} below it or in the face map, not both"
            yield Finding(coarse.content.tile.place, measured, "the same objects")
        yield from _tile_faults(coarse.content, finer, found)


def _tile_faults(content: Content, finer: list[Content], found: FaceMap) -> Iterator[Finding]:
    """Faults of the tile of a coarse content, with the nav contents below it."""
    tile, level = content.tile, content.nav["level"]
    if tile.refine != "REPLACE":
        yield Finding(f"{tile.place}/refine", repr(tile.refine), "'REPLACE'")
    for other in finer:
        if other.nav["level"] >= level:
            where = f"{other.place}/extensions/{EXTENSION}/level"
            yield Finding(where, str(other.nav["level"]), f"less than {level}")
    least = float(np.max([0.0, *found.errors, *(_number(other.tile.error) for other in finer)]))
    if not _number(tile.error) >= least:
        yield Finding(f"{tile.place}/geometricError", str(tile.error), f"{least:.9g} or more")


def _number(value: Any) -> float:
    """A geometric error as it stands in the file; NaN, for which no comparison holds, where it is none."""
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if good else float("nan")


@check("level/error-holds", needs=("level/faces-covered",))
def error_holds(subject: Subject) -> Findings:
    """Points of fine and coarse faces against those that stand for them, or that they stand for."""
    random = np.random.default_rng([subject.settings.seed, 6])
    weights = _weights(random)
    measured = 0
    for coarse, found, primitives in _members(subject):
        row = rows(found.listed.offsets)
        corners = facemaps.corners_of(primitives)
        errors = found.errors[facemaps.primitive_of(primitives)] + subject.tolerance
        fine, inverse = np.unique(found.listed.values, return_inverse=True)
        points = subject.faces.points
        of_object = np.zeros(subject.number("objectCount"))
        of_object[found.objects] = found.errors + subject.tolerance
        down = _farthest((points[fine], inverse), (corners, row), weights)
        up = _farthest((corners, row), (points, found.listed.values), weights)
        measured += (len(down) + len(up)) * len(weights)
        for index in np.flatnonzero(down > of_object[subject.faces.objects[fine]]):
            limit = of_object[subject.faces.objects[fine[index]]] - subject.tolerance
            where = f"{coarse.content.place} face {fine[index]} of level 0"
            yield Finding(where, f"a point {down[index]:.9g} m away", f"at most {limit:.9g} m")
        for index in np.flatnonzero(up > errors):
            limit = errors[index] - subject.tolerance
            where = f"{coarse.content.place} face {index}"
            yield Finding(where, f"a point {up[index]:.9g} m away", f"at most {limit:.9g} m")
    return NotRefuted(f"{measured} points, seed {subject.settings.seed}") if measured else None


def _weights(random: np.random.Generator) -> NDArray[np.float64]:
    """Barycentric weights of the points on a face, shape (k, 3)."""
    lattice = [(PARTS - i - j, i, j) for i in range(PARTS + 1) for j in range(PARTS + 1 - i)]
    return np.concatenate((np.array(lattice) / PARTS, random.dirichlet((1.0, 1.0, 1.0), RANDOM)))


def _farthest(
    sources: tuple[NDArray[np.float64], NDArray[np.int64]],
    targets: tuple[NDArray[np.float64], NDArray[np.int64]],
    weights: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Greatest distance of a point of each source from the nearest of its targets.

    Sources and targets are corners of faces, shape (n, 3, 3), and for each pair the number of its face.
    """
    corners, number = sources
    least = np.full((len(corners), len(weights)), np.inf)
    for start in range(0, len(number), BATCH):
        part = slice(start, start + BATCH)
        points = np.einsum("kc,ncd->nkd", weights, corners[number[part]])
        np.minimum.at(least, number[part], to_triangles(points, targets[0][targets[1][part]]))
    return np.asarray(least.max(axis=1, initial=0.0))

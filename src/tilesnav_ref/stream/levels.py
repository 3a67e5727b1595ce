"""The levels of a tileset, by object: geometry on the grid, errors, and what stands for what."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.contents import ContentRef, object_offsets
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.facemaps import open_face_map
from tilesnav_ref.stream.fields import Fields
from tilesnav_ref.stream.glb import open_glb
from tilesnav_ref.stream.tables import Ragged

COORDINATE_LIMIT = 1 << 23
"""Grid coordinates are less than this in magnitude."""


@dataclass(frozen=True)
class LevelScale:
    """What level codes stand for: code k for reference / base^(k + 1) < L <= reference / base^k."""

    reference: float = 1.0
    """L of the upper end of code 0, 1/m."""
    base: float = 2.0
    level_count: int = 16

    def upper(self) -> NDArray[np.float64]:
        """(level_count,) largest L of every code, 1/m; infinite for code 0, which has no upper end.

        Notes
        -----
        A code k is not greater than that of the largest L of the object, so this L is not above entry k.
        """
        steps = np.arange(self.level_count, dtype=np.float64)
        with np.errstate(over="ignore", under="ignore"):
            upper = self.reference / np.power(self.base, steps)
        upper[0] = np.inf
        return np.asarray(upper, dtype=np.float64)


def read_scale(lod: Fields) -> LevelScale:
    """Read the member `lod` of the entry object.

    Raises
    ------
    TilesetError
        When a number is not in its range.
    """
    scale = LevelScale(lod.number("reference"), lod.number("base"), lod.integer("levelCount", 1, 256))
    if scale.reference <= 0.0:
        raise lod.error("reference", scale.reference, "a number greater than 0")
    if scale.base <= 1.0:
        raise lod.error("base", scale.base, "a number greater than 1")
    return scale


@dataclass(frozen=True)
class LevelFaces:
    """The faces of all objects at one level, object after object."""

    offsets: NDArray[np.int64]
    """(K + 1,) first face of every object, and the number of faces."""
    corners: NDArray[np.int32]
    """(F, 3, 3) in grid steps, nav frame; of a face the least of the three rotations."""


@dataclass(frozen=True)
class Level:
    """A coarse level. Faces are those of `geometry`; the order of contents plays no part any more."""

    level: int
    errors: NDArray[np.float64]
    """(K,) error of every object, m."""
    geometry: LevelFaces
    fine_faces: Ragged
    """Faces of level 0 that each face stands for."""

    @cached_property
    def standing(self) -> Ragged:
        """Faces of this level that stand for each face of level 0, ascending; no list is empty."""
        sizes = self.fine_faces.lengths()
        coarse = np.repeat(np.arange(len(sizes)), sizes)
        fine = self.fine_faces.values.astype(np.int64)
        # A stable sort keeps the coarse faces of a fine one in their order.
        order = np.argsort(fine, kind="stable")
        counts = np.bincount(fine)
        return Ragged(np.concatenate((np.zeros(1, np.int64), np.cumsum(counts))), coarse[order])


def read_faces(contents: tuple[ContentRef, ...], offsets: NDArray[np.int64], step: float) -> LevelFaces:
    """Read the geometry of contents, primitive after primitive.

    Parameters
    ----------
    contents : tuple of ContentRef
        Of one level, by contentId.
    offsets : (K + 1,) int64
        First face of every primitive, and the number of faces: :func:`object_offsets` of the contents.
    step : float
        Grid step, m.

    Raises
    ------
    TilesetError
        When a content cannot be read or a position is not on the grid.
    """
    corners = np.empty((int(offsets[-1]), 3, 3), np.int32)
    first = 0
    for content in contents:
        glb = open_glb(content.path)
        for primitive in range(content.object_count):
            faces = on_grid(glb.corners(primitive), step, content)
            corners[first : first + len(faces)] = faces
            first += len(faces)
    return LevelFaces(offsets, smallest_first(corners))


def read_level(contents: tuple[ContentRef, ...], fine_offsets: NDArray[np.int64], step: float) -> Level:
    """Read a coarse level.

    Parameters
    ----------
    contents : tuple of ContentRef
        All contents of the level, by contentId.
    fine_offsets : (K + 1,) int64
        First face of every object of level 0, and the number of faces.
    step : float
        Grid step, m.

    Raises
    ------
    TilesetError
        When a content or a face map is not sound, or an object is not stood for by exactly one primitive.
    """
    offsets = object_offsets(contents)
    ends = np.cumsum([0, *(content.object_count for content in contents)])
    maps = [
        open_face_map(content, offsets[a : b + 1] - offsets[a], fine_offsets)
        for content, a, b in zip(contents, ends, ends[1:], strict=False)
    ]
    objects = np.concatenate([one.objects for one in maps]).astype(np.int64)
    order = np.argsort(objects, kind="stable")
    if not np.array_equal(objects[order], np.arange(len(fine_offsets) - 1)):
        found = f"{len(objects)} primitives for {len(np.unique(objects))} objects"
        allowed = f"each of the {len(fine_offsets) - 1} objects exactly once"
        raise TilesetError(str(maps[0].path), f"objects of level {contents[0].level}", found, allowed)
    # Rows of the faces, object after object instead of content after content.
    rows = Ragged(offsets, np.arange(offsets[-1])).take(order)
    corners = read_faces(contents, offsets, step).corners[rows.values]
    return Level(
        contents[0].level,
        np.concatenate([one.errors for one in maps])[order],
        LevelFaces(rows.offsets, corners),
        _joined([one.faces for one in maps]).take(rows.values),
    )


def _joined(lists: list[Ragged]) -> Ragged:
    sizes = np.concatenate([one.lengths() for one in lists])
    offsets = np.concatenate((np.zeros(1, np.int64), np.cumsum(sizes)))
    return Ragged(offsets, np.concatenate([one.values for one in lists]))


def on_grid(corners: NDArray[np.float32], step: float, content: ContentRef) -> NDArray[np.int32]:
    """Turn metres into grid steps, exactly.

    Raises
    ------
    TilesetError
        When a coordinate is no whole multiple of the step, or too large.
    """
    # A power of two: the quotient is exact.
    grid = corners.astype(np.float64) / step
    bad = ~((np.abs(grid) < COORDINATE_LIMIT) & (grid == np.floor(grid)))
    if bad.any():
        allowed = f"a multiple of {step} m of magnitude less than {COORDINATE_LIMIT * step} m"
        raise TilesetError(str(content.path), "POSITION", f"{corners[bad][0]}", allowed)
    return grid.astype(np.int32)


def smallest_first(corners: NDArray[np.int32]) -> NDArray[np.int32]:
    """Turn the corners of every face until their nine numbers are the lexicographically smallest.

    Parameters
    ----------
    corners : (F, 3, 3) int32
        Faces, corners, coordinates.

    Returns
    -------
    (F, 3, 3) int32
        The same cyclic order.

    Examples
    --------
    >>> smallest_first(np.array([[[2, 0, 0], [1, 9, 9], [1, 9, 8]]], np.int32)).tolist()
    [[[1, 9, 8], [2, 0, 0], [1, 9, 9]]]
    """
    wide = corners.astype(np.int64) + COORDINATE_LIMIT
    # Two of the three coordinates, of 24 bits each, in one number; the third settles ties.
    key, last = (wide[:, :, 0] << 24) + wide[:, :, 1], wide[:, :, 2]
    first = np.zeros(len(corners), np.int64)
    rows = np.arange(len(corners))
    for other in (1, 2):
        a, b = key[rows, first], key[:, other]
        less = (b < a) | ((b == a) & (last[:, other] < last[rows, first]))
        first[less] = other
    # Of two least corners that coincide the one counts that the other follows.
    same = (key[:, 0] == key[:, 2]) & (last[:, 0] == last[:, 2])
    all_same = same & (key[:, 0] == key[:, 1]) & (last[:, 0] == last[:, 1])
    first[same & ~all_same & (first == 0)] = 2
    turned = (first[:, None] + np.arange(3)) % 3
    return np.asarray(corners[rows[:, None], turned], dtype=np.int32)

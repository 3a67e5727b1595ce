"""Objects: parts of the file, or connected components; small ones merged with a neighbour, large ones
divided in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tilesnav_ref.scene.settings import SceneSettings
from tilesnav_ref.scene.topology import face_components, first_seen_numbers


def form_objects(
    vertices: NDArray[np.int64],
    faces: NDArray[np.int64],
    part: NDArray[np.int64],
    names: tuple[str, ...],
    settings: SceneSettings,
    kind: NDArray[np.int64] | None = None,
) -> tuple[NDArray[np.int64], tuple[str, ...]]:
    """Give every face an object.

    Parameters
    ----------
    vertices : (V, 3) int64
        Grid coordinates.
    faces : (F, 3) int64
    part : (F,) int64
        Part of the file that each face comes from.
    names : tuple of str
        Name of each part.
    settings : SceneSettings
    kind : (F,) int64 or None
        Kind of each face (kinds.py), the same for a whole part; objects of different kinds are never merged.

    Returns
    -------
    face_object : (F,) int64
        0, 1, ... in the order of first faces.
    object_names : tuple of str
        That of the largest part or component in it; the numbers of pieces of a divided object follow a slash.
    """
    several = len(np.unique(part)) > 1
    group = part if several else face_components(len(vertices), faces)
    object_of = first_seen_numbers(group)
    _, first = np.unique(object_of, return_index=True)
    labels = [names[part[i]] if several else f"{names[part[i]]}#{k}" for k, i in enumerate(first)]
    kind = np.zeros(len(faces), np.int64) if kind is None else kind
    merged = _merge_alike(vertices, faces, (object_of, kind), settings)
    sizes = np.bincount(object_of)
    owner = merged[first]
    by_size = np.lexsort((np.arange(len(first)), -sizes))
    largest = by_size[np.unique(owner[by_size], return_index=True)[1]]
    return _divide_large(vertices, faces, merged, [labels[k] for k in largest], settings.object_faces_max)


def _merge_alike(
    vertices: NDArray[np.int64],
    faces: NDArray[np.int64],
    given: tuple[NDArray[np.int64], NDArray[np.int64]],
    settings: SceneSettings,
) -> NDArray[np.int64]:
    """Merge small objects, but none with one of another kind; `given` is object and kind of every face."""
    object_of, kind = given
    result = np.zeros(len(faces), np.int64)
    count = 0
    for one in np.unique(kind):
        chosen = kind == one
        merged = merge_small(vertices, faces[chosen], first_seen_numbers(object_of[chosen]), settings)
        result[chosen] = merged + count
        count += int(merged.max()) + 1
    return first_seen_numbers(result)


def merge_small(
    vertices: NDArray[np.int64],
    faces: NDArray[np.int64],
    object_of: NDArray[np.int64],
    settings: SceneSettings,
) -> NDArray[np.int64]:
    """Merge objects of few faces with the nearest object, until none is left that has one in reach.

    Notes
    -----
    Distance is that of box middles. A small object that is longer than the reach (ground of two triangles)
    stays alone: its level code follows its nearest point, and it would force its own on a house.
    """
    reach = settings.object_reach / settings.step
    current = object_of
    while len(faces):
        sizes = np.bincount(current)
        lower, upper = object_boxes(vertices, faces, current)
        lengths = (upper - lower).max(axis=1)
        open_ = np.flatnonzero(lengths <= reach)  # may merge and be merged with
        small = open_[sizes[open_] < settings.object_faces_min]
        if len(open_) < 2 or not len(small):
            return current
        middles = (lower + upper) / 2
        distance, nearest = cKDTree(middles[open_]).query(middles[small], k=2)
        other = np.where(open_[nearest[:, 0]] == small, nearest[:, 1], nearest[:, 0])
        gap = np.where(open_[nearest[:, 0]] == small, distance[:, 1], distance[:, 0])
        near = gap <= reach
        if not near.any():
            return current
        current = first_seen_numbers(_join(len(sizes), small[near], open_[other[near]])[current])
    return current


def _join(count: int, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.int64]:
    """Label of each of `count` things after joining pairs."""
    label = np.arange(count)
    while True:
        least = np.minimum(label[first], label[second])
        following = label.copy()
        np.minimum.at(following, first, least)
        np.minimum.at(following, second, least)
        following = following[following]
        if np.array_equal(following, label):
            return label
        label = following


def object_boxes(
    vertices: NDArray[np.int64], faces: NDArray[np.int64], object_of: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(K, 3) least and greatest coordinates of every object."""
    count = int(object_of.max()) + 1 if len(object_of) else 0
    corners = vertices[faces]
    order = np.argsort(object_of, kind="stable")
    starts = np.searchsorted(object_of[order], np.arange(count))
    lower = np.minimum.reduceat(corners.min(axis=1)[order], starts, axis=0)
    upper = np.maximum.reduceat(corners.max(axis=1)[order], starts, axis=0)
    return lower, upper


def kd_groups(points: NDArray[np.int64], weights: NDArray[np.int64], limit: int) -> list[NDArray[np.int64]]:
    """Divide points at weighted medians until no group weighs more than the limit or has one point.

    Parameters
    ----------
    points : (N, 3) int64
    weights : (N,) int64
        Greater than zero.
    limit : int

    Returns
    -------
    list of (n,) int64
        Indices into points; neighbouring groups of the list are near each other.
    """
    groups = []
    stack = [np.arange(len(points))]
    while stack:
        chosen = stack.pop()
        if len(chosen) <= 1 or weights[chosen].sum() <= limit:
            groups.append(chosen)
            continue
        spread = points[chosen].max(axis=0) - points[chosen].min(axis=0)
        ordered = chosen[np.argsort(points[chosen, int(np.argmax(spread))], kind="stable")]
        total = np.cumsum(weights[ordered])
        cut = int(np.clip(np.searchsorted(total, total[-1] / 2) + 1, 1, len(ordered) - 1))
        stack += [ordered[cut:], ordered[:cut]]
    return groups


def _divide_large(
    vertices: NDArray[np.int64],
    faces: NDArray[np.int64],
    object_of: NDArray[np.int64],
    names: list[str],
    limit: int,
) -> tuple[NDArray[np.int64], tuple[str, ...]]:
    """Divide objects of more than `limit` faces by the middles of their faces."""
    sizes = np.bincount(object_of)
    label = object_of.copy()
    by_label = list(names)
    for k in np.flatnonzero(sizes > limit):
        inside = np.flatnonzero(object_of == k)
        middles = vertices[faces[inside]].sum(axis=1)
        for n, piece in enumerate(kd_groups(middles, np.ones(len(inside), np.int64), limit)):
            if n:
                label[inside[piece]] = len(by_label)
                by_label.append(f"{names[k]}/{n}")
        by_label[k] = f"{names[k]}/0"
    final = first_seen_numbers(label)
    _, first = np.unique(final, return_index=True)
    return final, tuple(by_label[label[i]] for i in first)

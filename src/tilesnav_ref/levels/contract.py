"""Contraction of edges within a bound of the distance between the surfaces.

An edge is contracted onto one of its ends, so vertices of a coarse level are vertices of the fine one: they
lie on the grid, and planes that keep three corners keep their place exactly. Quadrics give the order only.
Whether an edge may be contracted is decided by measuring points of the fine faces against the faces that
would replace them, and points of these against the fine faces.

References
----------
M. Garland, P. Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997 (the order).
R. Klein, G. Liebich, W. Strasser, "Mesh reduction with error control", Visualization 1996 (a contraction is
allowed when the part of the fine surface that it concerns stays within the bound).
"""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.levels.nearest import squared_distance
from tilesnav_ref.levels.surface import NONE, Surface, cost, has_corner, join, keeps_border, ring

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

UPRIGHT = 0.1
"""Least cosine of the turn of a face by one contraction; what turns farther counts as folded over."""
LATTICE = 4
"""Parts that the edges of a new face are divided into for the points that are measured on it."""


@kernel
def _cross(corners: Floats) -> tuple[float, float, float]:
    """Cross product of two edges of a triangle; exact for grid coordinates, which are below 2^23."""
    a0, a1, a2 = corners[1, 0] - corners[0, 0], corners[1, 1] - corners[0, 1], corners[1, 2] - corners[0, 2]
    b0, b1, b2 = corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1], corners[2, 2] - corners[0, 2]
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@kernel
def _upright(before: Floats, after: Floats) -> bool:
    """Whether a face keeps an area, and is not folded over."""
    p, q, r = _cross(before)
    x, y, z = _cross(after)
    if x == 0.0 and y == 0.0 and z == 0.0:
        return False
    along = p * x + q * y + r * z
    return bool(along >= UPRIGHT * np.sqrt((p * p + q * q + r * r) * (x * x + y * y + z * z)))


@kernel
def _same_face(surface: Surface, face: int, others: Ints, start: int, end: int) -> bool:
    """Whether one of the faces at end has the corners that a face gets with end in place of start."""
    for other in others:
        if has_corner(surface, other, start):
            continue
        same = True
        for k in range(3):
            corner = surface.faces[face, k]
            same = same and has_corner(surface, other, end if corner == start else corner)
        if same:
            return True
    return False


@kernel
def _targets(surface: Surface, start: int, end: int) -> tuple[Ints, Floats, int]:
    """Faces about start and end after the contraction, and their corners; those that move come first.

    Their number is -1 where the contraction is forbidden by a border, a fold, or because nothing remains.
    """
    here, there = ring(surface, start), ring(surface, end)
    numbers = np.empty(len(here) + len(there), np.int64)
    corners = np.empty((len(here) + len(there), 3, 3))
    shared = 0
    for face in here:
        if has_corner(surface, face, end):
            shared += 1
    if shared == 0 or not keeps_border(surface, here, start, end):
        return numbers[:0], corners[:0], -1
    count = 0
    before = np.empty((3, 3))
    for face in here:
        if has_corner(surface, face, end) or _same_face(surface, face, there, start, end):
            continue
        for k in range(3):
            corner = surface.faces[face, k]
            before[k] = surface.points[corner]
            corners[count, k] = surface.points[end if corner == start else corner]
        if not _upright(before, corners[count]):
            return numbers[:0], corners[:0], -1
        numbers[count] = face
        count += 1
    moved = count
    for face in there:
        if not has_corner(surface, face, start):
            for k in range(3):
                corners[count, k] = surface.points[surface.faces[face, k]]
            numbers[count] = face
            count += 1
    return numbers[:count], corners[:count], moved if count else -1


@kernel
def _near(point: Floats, corners: Floats, square: float) -> bool:
    """Whether one of some triangles is within a distance of a point."""
    near = False
    for triangle in corners:
        if squared_distance(triangle, point) <= square:
            near = True
            break
    return near


@kernel
def _samples_near(surface: Surface, start: int, corners: Floats, square: float) -> bool:
    """Whether the samples of the faces at start are near one of the faces that replace them."""
    for face in ring(surface, start):
        sample = surface.sample_heads[face]
        while sample != NONE:
            if not _near(surface.samples[sample], corners, square):
                return False
            sample = surface.sample_following[sample]
    return True


@kernel
def _fine_about(surface: Surface, numbers: Ints, marks: Ints, mark: int) -> Floats:
    """Corners of the fine faces that some faces stand for, each once."""
    found = np.empty(64, np.int64)
    count = 0
    for face in numbers:
        sample = surface.sample_heads[face]
        while sample != NONE:
            fine = surface.sample_fine[sample]
            if marks[fine] != mark:
                marks[fine] = mark
                if count == len(found):
                    longer = np.empty(2 * count, np.int64)
                    longer[:count] = found
                    found = longer
                found[count] = fine
                count += 1
            sample = surface.sample_following[sample]
    return surface.fine[found[:count]]


@kernel
def _lattice_near(triangle: Floats, fine: Floats, square: float) -> bool:
    """Whether points of a new face are near fine faces; its corners are corners of these."""
    point = np.empty(3)
    for i in range(LATTICE):
        for j in range(LATTICE + 1 - i):
            if j == LATTICE or (i == 0 and j == 0):
                continue
            for k in range(3):
                point[k] = (
                    (LATTICE - i - j) * triangle[0, k] + i * triangle[1, k] + j * triangle[2, k]
                ) / LATTICE
            if not _near(point, fine, square):
                return False
    return True


@kernel
def _commit(surface: Surface, start: int, end: int, numbers: Ints, corners: Floats) -> None:
    """Contract, and give each sample of the faces at start to the nearest of the faces that replace them."""
    waiting = NONE
    for face in ring(surface, start):
        sample = surface.sample_heads[face]
        surface.sample_heads[face] = NONE
        surface.alive[face] = False
        while sample != NONE:
            following = surface.sample_following[sample]
            surface.sample_following[sample] = waiting
            waiting = sample
            sample = following
    for face in numbers:
        surface.alive[face] = True
    join(surface, start, end)
    while waiting != NONE:
        sample, waiting = waiting, surface.sample_following[waiting]
        best, nearest = np.inf, 0
        for index in range(len(numbers)):
            square = squared_distance(corners[index], surface.samples[sample])
            if square < best:
                best, nearest = square, index
        face = numbers[nearest]
        surface.sample_following[sample] = surface.sample_heads[face]
        surface.sample_heads[face] = sample


@kernel
def _contract(surface: Surface, start: int, end: int, square: float, marks: Ints) -> bool:
    """Contract an edge onto its end where that is allowed; `marks` counts the tries in its last element."""
    numbers, corners, moved = _targets(surface, start, end)
    if moved < 0 or not _samples_near(surface, start, corners, square):
        return False
    marks[-1] += 1
    around = np.concatenate((numbers, ring(surface, start)))
    fine = _fine_about(surface, around, marks, marks[-1])
    for index in range(moved):
        if not _lattice_near(corners[index], fine, square):
            return False
    _commit(surface, start, end, numbers, corners)
    return True


@kernel
def contract_within(surface: Surface, bound: float) -> int:
    """Contract edges while points of the fine and the coarse faces stay within a distance of each other.

    Parameters
    ----------
    surface : Surface
        Changed in place.
    bound : float
        Grid steps.

    Returns
    -------
    int
        Number of contractions.

    Notes
    -----
    The points are a sample, so the distance of the surfaces can be somewhat larger than the bound; it is
    measured afterwards, with a bound that is proven (deviation.py). Edges are taken in the order of cost,
    numbers of their ends; so the result depends on nothing else.
    """
    square = bound * bound
    marks = np.zeros(len(surface.fine) + 1, np.int64)
    version = np.zeros(len(surface.points), np.int64)
    done = 0
    while True:
        queue = [(0.0, 0, 0, 0)]
        queue.pop()
        for face in range(len(surface.faces)):
            if surface.alive[face]:
                for k in range(3):
                    one, other = surface.faces[face, k], surface.faces[face, (k + 1) % 3]
                    queue.append((cost(surface, one, other), one, other, version[one] + version[other]))
                    queue.append((cost(surface, other, one), other, one, version[one] + version[other]))
        heapq.heapify(queue)
        before = done
        while len(queue) > 0:
            _, start, end, stamp = heapq.heappop(queue)
            if version[start] + version[end] != stamp or surface.heads[start] == NONE:
                continue
            if not _contract(surface, start, end, square, marks):
                continue
            done += 1
            version[end] += 1
            for face in ring(surface, end):
                for k in range(3):
                    other = surface.faces[face, k]
                    if other != end:
                        sum_ = version[end] + version[other]
                        heapq.heappush(queue, (cost(surface, end, other), end, other, sum_))
                        heapq.heappush(queue, (cost(surface, other, end), other, end, sum_))
        if done == before:
            return done

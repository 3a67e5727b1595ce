"""Searching for missing faces with rays: float32 and Embree suggest, nothing here decides."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator.exact import Candidate
from tilesnav_validator.polyhedra import Polyhedra
from tilesnav_validator.ragged import take
from tilesnav_validator.rayscene import RayScene
from tilesnav_validator.subject import Faces, position_numbers
from tilesnav_validator.tables import Ragged

Float32Array = NDArray[np.float32]
IntArray = NDArray[np.int64]

CHUNK = 2**16
"""Rays of a chunk: enough to hide the costs of a call, few enough for the second-level cache."""

_MARKS = 2**25
"""Most marks (cells of a chunk times faces), bytes."""

_SAME = 4
"""Candidates for the same cell and face that are kept of a chunk; the first may graze an edge."""

_SHARED = 16
"""Aimed rays that share a target: choosing one costs more than casting a ray."""

_DRAWS = 4
"""Times that a listed target is drawn again."""


@dataclass(frozen=True)
class Chunk:
    """Rays of one chunk: ``counts[i]`` from cell ``cells[i]``, either uniform or aimed."""

    number: int
    aimed: bool
    cells: IntArray
    counts: IntArray


@dataclass(frozen=True)
class Catch:
    """What a chunk brought in."""

    chunk: Chunk
    candidates: list[Candidate]


def plan(cells: IntArray, rays: int, face_count: int, seed: int) -> Iterator[Chunk]:
    """Spread rays evenly over cells and cut them into chunks: the uniform half, then the aimed half.

    Parameters
    ----------
    cells : ndarray of int64
        Numbers of the cells.
    rays : int
        Number of rays in all.
    """
    number = 0
    for aimed, total in ((False, rays - rays // 2), (True, rays // 2)):
        counts = np.full(len(cells), total // len(cells), dtype=np.int64)
        lucky = np.random.Generator(np.random.SFC64([seed, 3])).permutation(len(cells))
        counts[lucky[: total % len(cells)]] += 1
        ends = np.cumsum(counts)
        rows = max(1, _MARKS // max(face_count, 1))
        start = 0
        while start < total:
            first = int(np.searchsorted(ends, start, side="right"))
            stop = min(start + CHUNK, int(ends[min(first + rows, len(ends)) - 1]))
            last = int(np.searchsorted(ends, stop, side="left"))
            part = counts[first : last + 1].copy()
            part[0] = ends[first] - start
            part[-1] -= ends[last] - stop
            used = part > 0
            yield Chunk(number, aimed, cells[first : last + 1][used], part[used])
            number, start = number + 1, stop


class Caster:
    """Casts chunks of rays.

    Parameters
    ----------
    faces : Faces
    shapes : Polyhedra
        Of all cells.
    listed : Ragged
        Faces in the PVS of each cell.
    step : float
        Grid step, metres.
    seed : int
    max_range : float, optional
        Metres that segments must be shorter than.
    """

    def __init__(
        self,
        faces: Faces,
        shapes: Polyhedra,
        listed: Ragged,
        step: float,
        seed: int,
        max_range: float | None = None,
    ) -> None:
        self.faces, self.shapes, self.listed, self.seed = faces, shapes, listed, seed
        self.face_of_primitive = np.flatnonzero(faces.sound).astype(np.int32)
        grid = faces.grid[faces.sound]
        middle = (grid.min(axis=(0, 1)) + grid.max(axis=(0, 1))) // 2 if len(grid) else np.zeros(3, np.int64)
        # Differences of 24 bits: exact in float32.
        self.triangles = ((grid - middle) * step).astype(np.float32)
        self.centre = middle * step
        blocking = faces.blocking[faces.sound]
        self.blocking = RayScene(self.triangles, np.flatnonzero(blocking))
        self.porous = RayScene(self.triangles, np.flatnonzero(~blocking))
        self.has_porous = not blocking.all()
        self.one_sided = faces.one_sided[faces.sound]
        # What is a little beyond the range in float32 may be within it.
        self.reach = np.inf if max_range is None else max_range * (1 + 2.0**-12)
        self.corner_of, self.around = _incidence(grid)
        normals = shapes.planes[..., :3]
        self.is_box = (np.abs(normals).max(axis=2) == 1).all(axis=1)
        self.low = (shapes.low - self.centre).astype(np.float32)
        self.size = (shapes.high - shapes.low).astype(np.float32)
        both = np.concatenate([self.triangles.reshape(-1, 3), self.low, self.low + self.size])
        self.extent = float(np.linalg.norm(np.ptp(both, axis=0)))

    def cast(self, chunk: Chunk) -> Catch:
        """Cast the rays of a chunk; the result depends on the seed and the chunk alone."""
        if not len(self.triangles):
            return Catch(chunk, [])
        random = np.random.Generator(np.random.SFC64([self.seed, 4, chunk.number]))
        rows = np.repeat(np.arange(len(chunk.cells)), chunk.counts)
        marks = self._marks(chunk.cells)
        origins = self._origins(random, chunk, rows)
        if chunk.aimed:
            directions = self._targets(random, chunk, marks) - origins
        else:
            directions = _directions(random, len(rows))
        found: list[Candidate] = []
        for hits in self._hits(random, origins, directions):
            caught = np.flatnonzero(~marks[rows, hits])
            found += self._candidates(
                chunk, rows[caught], hits[caught], origins[caught], directions[caught]
            )
        return Catch(chunk, found)

    def _hits(
        self, random: np.random.Generator, origins: Float32Array, directions: Float32Array
    ) -> Iterator[IntArray]:
        """Triangles that rays hit within the range and from a side that counts, -1 for none.

        The first that is not porous; and, where there are porous ones, the first of those behind some place
        before that: every second ray looks from its origin, the others from a random place on their way.
        """
        hits, free = self.blocking.first_hits(origins, directions)
        length = np.linalg.norm(directions, axis=1)
        yield self._that_count(hits, free * length, directions)
        if not self.has_porous:
            return
        free = np.minimum(free, min(self.extent, self.reach) / length)
        start = (np.maximum(2 * random.random(len(free)) - 1, 0) * free).astype(np.float32)
        limits = np.maximum(free - start, 0).astype(np.float32)
        hits, further = self.porous.first_hits(origins + start[:, None] * directions, directions, limits)
        yield self._that_count(hits, (start + further) * length, directions)

    def _that_count(
        self, hits: IntArray, distances: NDArray[np.floating[Any]], directions: Float32Array
    ) -> IntArray:
        """Hits, with -1 in place of those out of range and those on one-sided triangles from behind."""
        kept = np.where(distances <= self.reach, hits, -1)
        sided = np.flatnonzero((kept >= 0) & self.one_sided[kept])
        corners = self.triangles[kept[sided]].astype(np.float64)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        kept[sided[(normals * directions[sided]).sum(axis=1) >= 0]] = -1
        return kept

    def _marks(self, cells: IntArray) -> NDArray[np.bool_]:
        """Which primitives are listed for each cell; the last column, that of -1, counts as listed."""
        by_face = np.zeros((len(cells), len(self.faces.objects) + 1), dtype=bool)
        row, index = take(self.listed.offsets, cells)
        by_face[row, self.listed.values[index]] = True
        by_face[:, -1] = True
        if len(self.face_of_primitive) == len(self.faces.objects):
            return by_face
        columns = np.append(self.face_of_primitive, len(self.faces.objects))
        return np.ascontiguousarray(by_face[:, columns])

    def _origins(self, random: np.random.Generator, chunk: Chunk, rows: IntArray) -> Float32Array:
        """Uniform positions in the cells."""
        origins = random.random((len(rows), 3), dtype=np.float32)
        origins *= np.repeat(self.size[chunk.cells], chunk.counts, axis=0)
        origins += np.repeat(self.low[chunk.cells], chunk.counts, axis=0)
        first = 0
        for cell, count in zip(chunk.cells, chunk.counts, strict=True):
            if not self.is_box[cell]:
                origins[first : first + count] = self._in_polyhedron(random, int(cell), int(count))
            first += int(count)
        return origins

    def _in_polyhedron(self, random: np.random.Generator, cell: int, count: int) -> Float32Array:
        """Uniform positions in one cell: a tetrahedron by its volume, then a position in it by sorted
        numbers."""
        facets = self.shapes.facet(np.full(6, cell), np.arange(6)) - self.centre
        apex = facets.reshape(-1, 3).mean(axis=0)
        fans = np.stack(
            [np.broadcast_to(facets[:, :1], facets[:, 2:].shape), facets[:, 1:-1], facets[:, 2:]], axis=2
        )
        edges = fans.reshape(-1, 3, 3) - apex
        volume = np.cumsum(np.abs(np.linalg.det(edges)))
        pick = np.minimum(np.searchsorted(volume, random.random(count) * volume[-1]), len(volume) - 1)
        weights = np.diff(np.sort(random.random((count, 3)), axis=1), axis=1, prepend=0.0)
        return np.asarray(apex + np.einsum("ke,kei->ki", weights, edges[pick]), dtype=np.float32)

    def _targets(self, random: np.random.Generator, chunk: Chunk, marks: NDArray[np.bool_]) -> Float32Array:
        """A position on a face to aim each ray at; a few rays in a row, from other positions, share one."""
        per_row = -(-chunk.counts // _SHARED)
        rows = np.repeat(np.arange(len(per_row)), per_row)
        target = self._neighbours(random, chunk.cells[rows])
        for _ in range(_DRAWS):
            again = np.flatnonzero(marks[rows, target])
            target[again] = random.integers(len(self.triangles), size=len(again), dtype=np.int64)
        share = random.random((len(rows), 2), dtype=np.float32)
        over = share.sum(axis=1) > 1
        share[over] = 1 - share[over]
        corners = self.triangles[target]
        base = corners[:, 0]
        points = base + share[:, :1] * (corners[:, 1] - base) + share[:, 1:] * (corners[:, 2] - base)
        uses = np.full(len(rows), _SHARED)
        uses[np.cumsum(per_row) - 1] = chunk.counts - _SHARED * (per_row - 1)
        return np.repeat(points, uses, axis=0)

    def _neighbours(self, random: np.random.Generator, cells: IntArray) -> IntArray:
        """For each cell a triangle that shares a corner with a listed one; any where nothing is listed.

        What a faulty encoder misses is seldom far from what it has found.
        """
        start, count = self.listed.offsets[cells], np.diff(self.listed.offsets)[cells]
        some = count > 0
        pick = start[some] + (random.random(int(some.sum())) * count[some]).astype(np.int64)
        primitive = np.searchsorted(self.face_of_primitive, self.listed.values[pick])
        primitive = np.minimum(
            primitive, len(self.triangles) - 1
        )  # a degenerate face stands for the next one
        corner = self.corner_of[primitive, random.integers(3, size=len(primitive))]
        first, last = self.around.offsets[corner], self.around.offsets[corner + 1]
        result = random.integers(len(self.triangles), size=len(cells), dtype=np.int64)
        result[some] = self.around.values[
            first + (random.random(len(corner)) * (last - first)).astype(np.int64)
        ]
        return result

    def _candidates(
        self,
        chunk: Chunk,
        rows: IntArray,
        hits: IntArray,
        origins: Float32Array,
        directions: Float32Array,
    ) -> Iterator[Candidate]:
        """Candidates of a chunk, at most ``_SAME`` for the same cell and face."""
        seen: dict[tuple[int, int], int] = {}
        for row, hit, origin, direction in zip(
            rows.tolist(), hits.tolist(), origins, directions, strict=True
        ):
            seen[row, hit] = seen.get((row, hit), 0) + 1
            if seen[row, hit] <= _SAME:
                c = origin.astype(np.float64) + self.centre
                face = int(self.face_of_primitive[hit])
                yield Candidate(int(chunk.cells[row]), face, c, direction.astype(np.float64))


def _incidence(grid: IntArray) -> tuple[IntArray, Ragged]:
    """Numbers of the corners of each triangle, shape (f, 3), and the triangles around each corner."""
    corner = position_numbers(grid).ravel()
    order = np.argsort(corner, kind="stable")
    offsets = np.concatenate([[0], np.cumsum(np.bincount(corner))]).astype(np.int64)
    return corner.reshape(-1, 3), Ragged(offsets, order // 3)


def _directions(random: np.random.Generator, count: int) -> Float32Array:
    """Uniform directions: height and azimuth are uniform (Archimedes)."""
    draw = random.random((2, count), dtype=np.float32)
    directions = np.empty((count, 3), dtype=np.float32)
    z = draw[0] * np.float32(2) - np.float32(1)
    around = draw[1] * np.float32(2 * np.pi)
    radius = np.sqrt(np.float32(1) - z * z)
    directions[:, 0] = radius * np.cos(around)
    directions[:, 1] = radius * np.sin(around)
    directions[:, 2] = z
    return directions


def cast_all(caster: Caster, chunks: Iterator[Chunk], threads: int) -> Iterator[Catch]:
    """Cast chunks on several threads (Embree and numpy release the lock); catches come in the order of the
    chunks."""
    with ThreadPoolExecutor(threads) as pool:
        waiting: deque[Future[Catch]] = deque(
            pool.submit(caster.cast, chunk) for chunk in islice(chunks, 2 * threads)
        )
        while waiting:
            catch = waiting.popleft().result()
            for chunk in islice(chunks, 1):
                waiting.append(pool.submit(caster.cast, chunk))
            yield catch

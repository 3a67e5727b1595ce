"""Faces that enter an object, as a coded body tells them: each beside an edge of one that is known."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import islice

from tilesnav_validator.packetbits import NUMBER, SIGNED, Bits
from tilesnav_validator.packetparts import REACH, BodyError

Place = tuple[int, int, int]
Corners = tuple[Place, Place, Place]
Edge = tuple[int, int, int, bool]
"""Vertices from which and to which it leads, the third vertex of its face, and whether that is held."""
Memory = dict[tuple[Place, Place], Place]

MOST_CANDIDATES = 4
MOST_EDGES = 8
_MEMORY, _PARALLEL, _TO, _FROM = 1, 2, 4, 8
"""Masks of where a candidate comes from."""

_KNOWN, _AGE, _EQUAL, _DIFFERENCE = 0, 1, 1 + NUMBER, 1 + NUMBER + 36
VERTEX = _DIFFERENCE + 3 * SIGNED
"""Contexts of a block for vertices."""
EXISTS, CHOICE = 3 * VERTEX, 3 * VERTEX + 4
CONTEXTS = CHOICE + 16
"""Contexts for faces that enter."""


def minus(left: Place, right: Place) -> Place:
    """Difference of two places."""
    return (left[0] - right[0], left[1] - right[1], left[2] - right[2])


def plus(left: Place, right: Place) -> Place:
    """Sum of two places."""
    return (left[0] + right[0], left[1] + right[1], left[2] + right[2])


class Mesh:
    """The known faces of an object."""

    def __init__(self) -> None:
        self.places: list[Place] = []
        self.numbers: dict[Place, int] = {}
        self.third: dict[tuple[int, int], int] = {}
        self.to: dict[int, list[int]] = defaultdict(list)
        self.leading: dict[int, list[int]] = defaultdict(list)

    def vertex(self, place: Place) -> int:
        """Number of the vertex at a place, put there unless there is one."""
        number = self.numbers.setdefault(place, len(self.places))
        if number == len(self.places):
            self.places.append(place)
        return number

    def add(self, face: tuple[int, int, int], held: bool) -> list[Edge]:
        """Put a face into the mesh; return its edges."""
        a, b, c = face
        edges = [(a, b, c, held), (b, c, a, held), (c, a, b, held)]
        for start, end, third, _ in edges:
            self.third[start, end] = third
            self.to[end].append(start)
            self.leading[start].append(end)
        return edges

    def corners(self, face: tuple[int, int, int]) -> Corners:
        """Places of the vertices of a face."""
        a, b, c = face
        return (self.places[a], self.places[b], self.places[c])

    def candidates(self, start: int, end: int, third: int | None, memory: Memory) -> dict[Place, int]:
        """Places where the third vertex behind an edge may be, with their masks, in order."""
        found: dict[Place, int] = {}
        for place, mask in self._proposed(start, end, third, memory):
            if place in found:
                found[place] |= mask
            elif len(found) < MOST_CANDIDATES and all(-REACH < value < REACH for value in place):
                found[place] = mask
        return found

    def _proposed(
        self, start: int, end: int, third: int | None, memory: Memory
    ) -> Iterator[tuple[Place, int]]:
        p, q = self.places[start], self.places[end]
        if third is not None:
            c = self.places[third]
            noted = memory.get((minus(q, p), minus(c, p)))
            if noted is not None:
                yield plus(p, noted), _MEMORY
            yield minus(plus(p, q), c), _PARALLEL
        for other in islice(reversed(self.to[start]), MOST_EDGES):
            if other != third and (start, other) not in self.third:
                yield self.places[other], _TO
        for other in islice(reversed(self.leading[end]), MOST_EDGES):
            if other != third and (other, end) not in self.third:
                yield self.places[other], _FROM


class Entering:
    """Decodes faces that enter, object by object.

    Parameters
    ----------
    bits : Bits
    first : int
        Its first context of ``CONTEXTS``.
    """

    def __init__(self, bits: Bits, first: int) -> None:
        self.bits, self.first = bits, first
        self.memory: Memory = {}
        self.last: Corners = ((0, 0, 0), (0, 0, 0), (0, 0, 0))

    def faces(self, held: Iterable[Corners], count: int) -> list[Corners]:
        """Faces that enter an object.

        Parameters
        ----------
        held : iterable of corners
            Faces that are held of the object, ascending by their number.
        count : int
            Number of faces that enter, more than 0.
        """
        mesh = Mesh()
        stack: list[Edge] = []
        for a, b, c in held:
            stack += mesh.add((mesh.vertex(a), mesh.vertex(b), mesh.vertex(c)), True)
        self._note(mesh, stack)
        stack.reverse()
        entered: list[Corners] = []
        while len(entered) < count:
            face = self._beside(mesh, stack.pop()) if stack else self._anew(mesh)
            if face is not None:
                stack += mesh.add(face, False)
                self.last = mesh.corners(face)
                entered.append(self.last)
        return entered

    def _note(self, mesh: Mesh, edges: list[Edge]) -> None:
        """Keep what lies behind the edges of held faces."""
        for start, end, third, _ in edges:
            behind = mesh.third.get((end, start))
            if behind is not None:
                self._remember(mesh, (start, end, third), behind)

    def _remember(self, mesh: Mesh, edge: tuple[int, int, int], behind: int) -> None:
        a, b, c = (mesh.places[vertex] for vertex in edge)
        self.memory[minus(b, a), minus(c, a)] = minus(mesh.places[behind], a)

    def _beside(self, mesh: Mesh, edge: Edge) -> tuple[int, int, int] | None:
        """The face behind an edge, if there is one that enters."""
        start, end, third, held = edge
        if (end, start) in mesh.third:
            return None
        a, b, c = mesh.places[start], mesh.places[end], mesh.places[third]
        noted = (minus(b, a), minus(c, a)) in self.memory
        if not self.bits.bit(self.first + EXISTS + 2 * noted + held):
            return None
        candidates = mesh.candidates(start, end, third, self.memory)
        vertex = self._third(mesh, candidates, (a, b, c))
        self._remember(mesh, (start, end, third), vertex)
        return (end, start, vertex)

    def _anew(self, mesh: Mesh) -> tuple[int, int, int]:
        """A face that is beside no edge."""
        second, third, first = self.last
        references = (first, second, third)
        start = self._vertex(mesh, 0, references)
        a = mesh.places[start]
        end = self._vertex(mesh, 1, (a, references[0], references[1]))
        b = mesh.places[end]
        candidates = mesh.candidates(end, start, None, self.memory)
        return (start, end, self._third(mesh, candidates, (b, a, references[0])))

    def _third(self, mesh: Mesh, candidates: dict[Place, int], references: Corners) -> int:
        for place, mask in candidates.items():
            if self.bits.bit(self.first + CHOICE + mask):
                return mesh.vertex(place)
        return self._vertex(mesh, 2, references)

    def _vertex(self, mesh: Mesh, block: int, references: Corners) -> int:
        """Number of a vertex, a known one or one at a new place."""
        bits, first = self.bits, self.first + block * VERTEX
        known = len(mesh.places)
        if known and bits.bit(first + _KNOWN):
            age = bits.number(first + _AGE)
            if age >= known:
                raise BodyError("body", f"vertex {age} before the latest", f"less than {known}")
            return known - 1 - age
        place, same = [], 0
        for axis in range(3):
            value, same = self._coordinate(first, axis, same, [place[axis] for place in references])
            place.append(value)
        return mesh.vertex((place[0], place[1], place[2]))

    def _coordinate(self, first: int, axis: int, same: int, references: list[int]) -> tuple[int, int]:
        """A coordinate of a new place, and which reference it is that of, counted from 1."""
        for k, value in enumerate(references):
            if value not in references[:k] and self.bits.bit(first + _EQUAL + 12 * axis + 3 * same + k):
                return value, k + 1
        value = references[0] + self.bits.signed(first + _DIFFERENCE + axis * SIGNED)
        if not -REACH < value < REACH:
            raise BodyError("body", f"coordinate {value}", "magnitudes less than 2^23")
        return value, 0

"""Coded bodies, written straight from Annex D: every list is searched, nothing is kept for speed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from casebuilder.bit_writer import BitWriter
from casebuilder.world import Point, Triangle

LIMIT = 2**23
Edge = tuple[Point, Point, Point, bool]
"""From, to, third vertex, whether its face is held."""


class Part(Protocol):
    """What is held of an object."""

    @property
    def level(self) -> int: ...
    @property
    def flags(self) -> int: ...
    @property
    def faces(self) -> dict[int, Triangle]: ...


def coded(before: dict[int, Part], after: dict[int, Part]) -> bytes:
    """The body that leads from parts to others."""
    writer = BitWriter()
    new = [item for item in sorted(after) if item not in before]
    writer.number("NEW", len(new))
    for place, item in enumerate(new):
        writer.number("NEW", item - (new[place - 1] + 1 if place else 0))
    for item in sorted(before):
        writer.number("ACTION", _action(before[item], after.get(item)))
    changed = [i for i in sorted(after) if i in before and _action(before[i], after[i]) == 1]
    replaced = [i for i in sorted(after) if i in new or _action(before[i], after[i]) == 3]
    for item in changed:
        writer.number("LEFT", len(before[item].faces.keys() - after[item].faces.keys()))
    for item in replaced:
        writer.number("LEVEL", after[item].level)
    for item in replaced:
        writer.number("FLAGS", after[item].flags)
    held = {item: before[item].faces if item in changed else {} for item in changed + replaced}
    for item in sorted(held):
        writer.number("COUNT", len(after[item].faces.keys() - held[item].keys()))
    coder = _FaceCoder(writer)
    for item in sorted(held):
        _leaving(writer, held[item], after[item].faces)
        entering = {n: face for n, face in after[item].faces.items() if n not in held[item]}
        if entering:
            coder.enter(list(held[item].values()), list(entering.values()))
            _numbers(writer, held[item], entering)
    return writer.body()


def _action(before: Part, after: Part | None) -> int:
    """What happens to a part: 0 same, 1 changed, 2 gone, 3 replaced."""
    if after is None:
        return 2
    if (before.level, before.flags) != (after.level, after.flags):
        return 3
    return int(before.faces.keys() != after.faces.keys())


def _leaving(writer: BitWriter, held: dict[int, Triangle], after: dict[int, Triangle]) -> None:
    leaves = [face not in after for face in held]
    last = 0
    for place, one in enumerate(leaves):
        rest = leaves[place:]
        if any(rest) and not all(rest):
            writer.bit(("LEAVE", last), one)
            last = int(one)


@dataclass
class _Mesh:
    """Known faces of an object: its vertices and edges in the order in which they come."""

    vertices: list[Point] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)

    def put(self, *places: Point) -> None:
        for place in places:
            if place not in self.vertices:
                self.vertices.append(place)

    def add(self, face: Triangle, held: bool) -> list[Edge]:
        a, b, c = face
        self.put(a, b, c)
        mine = [(a, b, c, held), (b, c, a, held), (c, a, b, held)]
        self.edges += mine
        return mine

    def third(self, start: Point, end: Point) -> Point | None:
        """Third vertex of the latest edge between two vertices."""
        found = [c for a, b, c, _ in self.edges if (a, b) == (start, end)]
        return found[-1] if found else None


def _sum(*terms: tuple[int, Point]) -> Point:
    x, y, z = (sum(sign * place[axis] for sign, place in terms) for axis in range(3))
    return (x, y, z)


class _FaceCoder:
    """Writes faces that enter, object by object."""

    def __init__(self, writer: BitWriter) -> None:
        self.writer = writer
        self.memory: dict[tuple[Point, Point], Point] = {}
        origin = (0, 0, 0)
        self.last: Triangle = (origin, origin, origin)

    def enter(self, held: list[Triangle], entering: list[Triangle]) -> None:
        """Write the faces that enter an object, in an order that their edges give."""
        mesh = _Mesh()
        for face in held:
            mesh.add(face, True)
        for a, b, c, _ in mesh.edges:
            behind = mesh.third(b, a)
            if behind is not None:
                self._note((a, b, c), behind)
        stack, left = mesh.edges[::-1], list(entering)
        while left:
            if not stack:
                face = left.pop(0)
                self._anew(mesh, face)
            else:
                edge = stack.pop()
                if mesh.third(edge[1], edge[0]) is not None:
                    continue
                found = self._beside(mesh, edge, left)
                if found is None:
                    continue
                face = found
            stack += mesh.add(face, False)
            self.last = face

    def _note(self, face: Triangle, behind: Point) -> None:
        a, b, c = face
        self.memory[_sum((1, b), (-1, a)), _sum((1, c), (-1, a))] = _sum((1, behind), (-1, a))

    def _beside(self, mesh: _Mesh, edge: Edge, left: list[Triangle]) -> Triangle | None:
        """Write whether there is a face behind an edge, and which one."""
        a, b, c, held = edge
        turns = [(face, turn) for face in left for turn in _turns(face) if turn[:2] == (b, a)]
        noted = (_sum((1, b), (-1, a)), _sum((1, c), (-1, a))) in self.memory
        self.writer.bit(("EXISTS", noted, held), bool(turns))
        if not turns:
            return None
        face, turn = turns[0]
        left.remove(face)
        self._third(mesh, self._candidates(mesh, a, b, c), turn[2], (a, b, c))
        self._note((a, b, c), turn[2])
        return turn

    def _anew(self, mesh: _Mesh, face: Triangle) -> None:
        a, b, v = face
        second, third, first = self.last
        self._vertex(mesh, 0, a, (first, second, third))
        self._vertex(mesh, 1, b, (a, first, second))
        self._third(mesh, self._candidates(mesh, b, a, None), v, (b, a, first))

    def _candidates(self, mesh: _Mesh, p: Point, q: Point, c: Point | None) -> list[tuple[Point, int]]:
        """Places where the third vertex behind the edge (p, q) may be, with their masks."""
        proposed: list[tuple[Point, int]] = []
        if c is not None:
            noted = self.memory.get((_sum((1, q), (-1, p)), _sum((1, c), (-1, p))))
            proposed += [] if noted is None else [(_sum((1, p), (1, noted)), 1)]
            proposed.append((_sum((1, p), (1, q), (-1, c)), 2))
        to = [start for start, end, _, _ in reversed(mesh.edges) if end == p][:8]
        proposed += [(w, 4) for w in to if w != c and mesh.third(p, w) is None]
        leading = [end for start, end, _, _ in reversed(mesh.edges) if start == q][:8]
        proposed += [(w, 8) for w in leading if w != c and mesh.third(w, q) is None]
        found: list[tuple[Point, int]] = []
        for place, mask in proposed:
            known = [i for i, (other, _) in enumerate(found) if other == place]
            if known:
                found[known[0]] = (place, found[known[0]][1] | mask)
            elif len(found) < 4 and max(map(abs, place)) < LIMIT:
                found.append((place, mask))
        return found

    def _third(
        self, mesh: _Mesh, candidates: list[tuple[Point, int]], vertex: Point, references: Triangle
    ) -> None:
        for place, mask in candidates:
            self.writer.bit(("CHOICE", mask), place == vertex)
            if place == vertex:
                mesh.put(vertex)
                return
        self._vertex(mesh, 2, vertex, references)

    def _vertex(self, mesh: _Mesh, block: int, vertex: Point, references: Triangle) -> None:
        name = ("VERTEX", block)
        known = vertex in mesh.vertices
        if mesh.vertices:
            self.writer.bit((name, "KNOWN"), known)
        if known:
            self.writer.number((name, "AGE"), len(mesh.vertices) - 1 - mesh.vertices.index(vertex))
            return
        s = 0
        for axis in range(3):
            s = self._coordinate((name, axis, s), vertex[axis], [place[axis] for place in references])
        mesh.put(vertex)

    def _coordinate(self, where: tuple[object, int, int], value: int, references: list[int]) -> int:
        """Write a coordinate; return the s of the next one."""
        name, axis, s = where
        for k, reference in enumerate(references):
            if reference in references[:k]:
                continue
            self.writer.bit((name, "EQUAL", axis, s, k), reference == value)
            if reference == value:
                return k + 1
        self.writer.signed((name, "DIFFERENCE", axis), value - references[0])
        return 0


def _turns(face: Triangle) -> list[Triangle]:
    a, b, c = face
    return [(a, b, c), (b, c, a), (c, a, b)]


def _on_curve(face: Triangle) -> int:
    place = 0
    for axis in range(3):
        cell = (sum(corner[axis] for corner in face) // 3 + 2**23) >> 3
        place += sum(((cell >> i) & 1) << (3 * i + axis) for i in range(21))
    return place


def _numbers(writer: BitWriter, held: dict[int, Triangle], entering: dict[int, Triangle]) -> None:
    """Write the numbers of faces that enter, along the curve."""
    rows = [(_on_curve(face), 0, (), number, False) for number, face in held.items()]
    entries = [(_on_curve(f), 1, tuple(v for p in f for v in p), n, True) for n, f in entering.items()]
    order = [(number, enters) for _, _, _, number, enters in sorted([*rows, *entries])]
    expected = 0
    for place, (number, enters) in enumerate(order):
        if enters:
            later = [i for i in range(place, len(order)) if not order[i][1]]
            room = 7
            if later:
                room = min(max(order[later[0]][0] - expected - (later[0] - place) + 1, 0), 6)
            writer.bit(("PLACE", room), number != expected)
            if number != expected:
                writer.bit(("NEGATIVE", room), number < expected)
                writer.number(("GAP", room), abs(number - expected) - 1)
        expected = number + 1

"""Certificates whose regions are prisms: a cell with a slanted side, and a box cell in prisms of every shape.

The cell is 1 <= x <= 3, 0.5 <= z <= 2 and y <= 2, and its fourth side across x and y runs from (1, 0) to
(3, -1.5), so that y >= -0.75 (x - 1). Its plane is 0.6 x + 0.8 y >= 0.6 in FLOAT64, which passes through
(1, 0) exactly and a little above (3, -1.5). A wall runs along y = -0.75 (x - 1) - 0.5, within the box around
the cell, and hides a sheet in the plane y = -3. Another wall stands in the plane x = 0, from y = 0 on; what
it hides, in the plane x = -3 with y >= 2, the missing corner (1, -1.5) of that box would see below y = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import nextafter

from casebuilder.assemble import Case
from casebuilder.edits import Edits, edits
from casebuilder.proofs import Maker, Proof, Proofs
from casebuilder.state import State
from casebuilder.world import IDENTITY, Cell, Lod, Object, World, quad
from casebuilder.worlds import GROUND, HIDING


def oblique_cell(distance: float = 0.6) -> Cell:
    """The cell, with its slanted plane at a distance from the origin."""
    return Cell(
        (
            (-1.0, 0.0, 0.0, 1.0),
            (1.0, 0.0, 0.0, -3.0),
            (-0.6, -0.8, 0.0, distance),
            (0.0, 1.0, 0.0, -2.0),
            (0.0, 0.0, -1.0, 0.5),
            (0.0, 0.0, 1.0, -2.0),
        )
    )


ALONG = Object(0, (quad((0.5, -0.125, 0), (4.5, -3.125, 0), (4.5, -3.125, 4), (0.5, -0.125, 4)),))
ACROSS = Object(0, (quad((0, 0, 0), (0, 4, 0), (0, 4, 4), (0, 0, 4)),))
SOUTH_SHEET = Object(0, (quad((1, -3, 0.5), (2, -3, 0.5), (2, -3, 2), (1, -3, 2)),))
WEST_SHEET = Object(0, (quad((-3, 2, 0.5), (-3, 3, 0.5), (-3, 3, 2), (-3, 2, 2)),))

OBLIQUE = World(
    (GROUND, ALONG, ACROSS, SOUTH_SHEET, WEST_SHEET),
    (oblique_cell(),),
    transform=IDENTITY,
    lod=Lod(6.0),  # with 5 the largest L of the slanted wall, 1 / 0.4 m, would be on the border of two codes
)
ALONG_FACES, ACROSS_FACES, SOUTH_FACES, WEST_FACES = [2, 3], [4, 5], [6, 7], [8, 9]

HALVED = replace(
    OBLIQUE,
    objects=(
        GROUND,
        Object(0, (quad((0, 1.125, 0), (0, 4, 0), (0, 4, 4), (0, 1.125, 4)),)),
        Object(0, (quad((-0.5, 0.5, 0), (-0.5, 1.875, 0), (-0.5, 1.875, 4), (-0.5, 0.5, 4)),)),
        WEST_SHEET,
    ),
)
"""The same cell and two walls that hide the western sheet together. A cut across y runs from (1, 1) to
(3, 0.25). From above it nothing passes x = 0 below y = 1.125, on the way from (3, 0.25) to (-3, 2); from
below it all is between y = 0.5 and y = 1.875 at x = -0.5."""
LEFT_FACES, RIGHT_FACES = [2, 3], [4, 5]


def stepped(low: float) -> World:
    """The same cell, the wall across, and one behind it that begins at a y and stands out above it.

    A cut across x leaves the corner (2, -0.75) to the part below it; from there to (-3, 2) the way meets
    x = -1 at y = 0.9, and from the corner (1, 0) at y = 1.
    """
    behind = Object(0, (quad((-1, low, 0), (-1, 4, 0), (-1, 4, 8), (-1, low, 8)),))
    return replace(OBLIQUE, objects=(GROUND, ACROSS, behind, WEST_SHEET))


FRONT_FACES, BEHIND_FACES = [2, 3], [4, 5]

LOWER, UPPER = (1024, 0, 512), (3072, 2048, 2048)
OWN = ((*LOWER, *UPPER), (-1536, 2048, 1))
"""The cell, with p, q and the shape: y slants along x."""
OUTER = ((1024, -512, 512, *UPPER), (-2048, 2048, 1))
"""The same as far as the slanted wall; the way from its corner (3, -2) to (-3, 2) meets x = 0 at y = 0."""


def oblique(_world: World, _states: list[State]) -> dict[int, Proofs]:
    """Certificates of the oblique cell; the last has a cut across x."""
    made = [
        Proof(OUTER[0], SOUTH_FACES, [ALONG_FACES], slant=OUTER[1]),
        Proof(OWN[0], WEST_FACES[:1], [ACROSS_FACES], slant=OWN[1]),
        Proof(OUTER[0], WEST_FACES[1:], [ACROSS_FACES] * 2, cuts=[1, 0, 0], slant=OUTER[1]),
    ]
    return {0: Proofs((0, 1), [[0, 1, 2]], made)}


def run_halves(_world: World, _states: list[State]) -> dict[int, Proofs]:
    """A cut across the run axis, and an occluder for each part, that of the part above first."""
    made = [
        Proof(OWN[0], [face], [FRONT_FACES, BEHIND_FACES], cuts=[1, 0, 0], slant=OWN[1]) for face in (6, 7)
    ]
    return {0: Proofs((0, 1), [[0, 1]], made)}


def halved(_world: World, _states: list[State]) -> dict[int, Proofs]:
    """A cut across the slanted axis, and an occluder for each part."""
    made = [
        Proof(OWN[0], [face], [LEFT_FACES, RIGHT_FACES], cuts=[2, 0, 0], slant=OWN[1]) for face in (6, 7)
    ]
    return {0: Proofs((0, 1), [[0, 1]], made)}


AXES = {1: (0, 1), 2: (1, 2), 3: (2, 0), 4: (0, 2), 5: (1, 0), 6: (2, 1)}


def every_shape(_world: World, _states: list[State]) -> dict[int, Proofs]:
    """A box cell in a prism of each shape, cut across x, then y, then z. Across the third axis the sum of the
    bounds is odd, which it cannot be across the run axis. A last prism has a box above a cut across y, and
    the sum of its bounds along x is odd."""
    proofs = Proofs((0, 1), [list(range(len(AXES) + 1))], [])
    for shape, (u, v) in AXES.items():
        lower, upper = [1024, -1024, 512], [3072, 1024, 2048]
        upper[3 - u - v] += 1
        slant = (lower[v] - 100, upper[v] + 200, shape)
        made = Proof((*lower, *upper), [4 + shape % 2], [[2, 3]] * 4, cuts=[1, 2, 3, 0, 0, 0, 0], slant=slant)
        proofs.certificates.append(made)
    region = (1024, -1025, 512, 3073, 1025, 2048)
    box_above = Proof(region, [4], [[2, 3]] * 3, cuts=[2, 1, 0, 0, 0], slant=(-1024, 1025, 1))
    proofs.certificates.append(box_above)
    return {0: proofs}


def prism_cases() -> Iterator[Case]:
    """Valid cases."""
    yield Case(
        "prism-proofs",
        OBLIQUE,
        "Regions that slant as their cell does, one of which touches its occluder and the shaft an edge.",
        "A checker that takes the box around a region, or around a part of it, for the region.",
        near=("certificate/region-holds-cell", "certificate/sound"),
        proofs=oblique,
    )
    yield Case(
        "prism-halves",
        HALVED,
        "Two walls hide a sheet together, each from a part of a prism cut across its slanted axis.",
        "A checker that cuts a prism parallel to an axis, or takes the parts in the wrong order.",
        proofs=halved,
    )
    yield Case(
        "prism-run-halves",
        stepped(0.875),
        "Two walls, each of which is the occluder of a part of a prism cut across its run axis.",
        "A checker that takes the bounds of the whole prism for those of its parts.",
        near=("certificate/sound",),
        proofs=run_halves,
    )
    yield Case(
        "prism-shapes",
        HIDING,
        "A certificate for each shape of a region, with cuts across every axis.",
        "A checker that confuses the axes of a shape, or asks for even sums where none are needed.",
        near=("certificate/tree", "certificate/container"),
        proofs=every_shape,
    )


def _changed(change: Callable[[Proofs], object], make: Maker = oblique, world: World = OBLIQUE) -> Edits:
    def made(of: World, states: list[State]) -> dict[int, Proofs]:
        proofs = make(of, states)
        change(proofs[0])
        return proofs

    return edits(world=world, proofs=made)


def _region(number: int, **members: int) -> Callable[[Proofs], None]:
    """Change of numbers of a region by their names: x, y, z, X, Y, Z, p, q and shape."""

    def edit(proofs: Proofs) -> None:
        proof = proofs.certificates[number]
        values = dict(zip("xyzXYZpqs", (*proof.region, *proof.slant), strict=True))
        values |= {name if name != "shape" else "s": value for name, value in members.items()}
        numbers = tuple(values.values())
        proof.region, proof.slant = numbers[:6], (numbers[6], numbers[7], numbers[8])

    return edit


def _cut(codes: list[int], **members: int) -> Callable[[Proofs], None]:
    """Change of the tree of the second certificate and of its region."""

    def edit(proofs: Proofs) -> None:
        proof = proofs.certificates[1]
        proof.cuts, proof.occluders = codes, proof.occluders * codes.count(0)
        _region(1, **members)(proofs)

    return edit


def _exchange(proofs: Proofs) -> None:
    proofs.certificates[0].occluders.reverse()


CASES: dict[str, Edits] = {
    "certificate/container/no-such-shape": _changed(_region(1, shape=7)),
    "certificate/container/box-with-p-and-q": _changed(_region(1, y=-1536, shape=0)),
    "certificate/container/box-as-a-prism": _changed(_region(1, y=-1536)),
    "certificate/container/prism-that-ends-in-an-edge": _changed(_region(1, p=2048)),
    "certificate/container/prism-out-of-reach": _changed(_region(1, p=-(2**29))),
    "certificate/region-holds-cell/slanted-side-one-unit-short": _changed(_region(1, p=-1535)),
    "certificate/region-holds-cell/upper-side-one-unit-short": _changed(_region(1, q=2047)),
    "certificate/region-holds-cell/slanted-side-by-a-hair": edits(
        world=replace(OBLIQUE, cells=(oblique_cell(nextafter(0.6, 0)),)), proofs=oblique
    ),
    "certificate/tree/run-with-an-odd-sum": _changed(_cut([1, 0, 0], X=3073, p=-1538)),
    "certificate/tree/slant-with-an-odd-sum": _changed(_cut([1, 0, 0], p=-1537)),
    "certificate/tree/prism-too-narrow-at-its-lower-end": _changed(_cut([2] * 12 + [0] * 13)),
    "certificate/tree/prism-too-narrow-at-its-upper-end": _changed(_cut([2, 0] * 12 + [0], y=-6144)),
    "certificate/sound/edge-before-the-middle-of-a-run": edits(world=stepped(0.9375), proofs=run_halves),
    "certificate/sound/occluder-in-the-prism": _changed(_region(0, y=-513)),
    "certificate/sound/box-around-a-prism": _changed(_region(0, y=-1536, p=0, q=0, shape=0)),
    "certificate/sound/edge-before-a-prism": _changed(_region(2, p=-2050)),
    "certificate/sound/parts-of-a-prism-exchanged": _changed(_exchange, halved, HALVED),
}

"""Valid cases with certificate files."""

from __future__ import annotations

from collections.abc import Iterator

from casebuilder.assemble import Case
from casebuilder.proofs import Proof, Proofs, one_each, region_of
from casebuilder.state import State
from casebuilder.world import World
from casebuilder.worlds import CONTACT, EAST, FUSED, HIDING, LOOSE, RING, SINGLE, SLANTED, TWO_SECTORS, UPPER

SHEET_FACES = [4, 5]
WALL_FACES = [2, 3]
BUILDING_FACES = list(range(6, 18))


def in_a_box(world: World, _states: list[State]) -> dict[int, Proofs]:
    """The two faces of the sheet as targets of one certificate."""
    proofs = Proofs((0, 1), [[0]], [])
    region = region_of(world.cells, proofs, world.exponent)
    proofs.certificates.append(Proof(region, SHEET_FACES, [WALL_FACES]))
    return {0: proofs}


def nothing(world: World, _states: list[State]) -> dict[int, Proofs]:
    """A file without a certificate."""
    return {0: Proofs(world.sectors[0], [[] for _ in world.cells], [])}


def plain(world: World, states: list[State]) -> dict[int, Proofs]:
    """A certificate of one leaf for each cell and hidden face, in every sector."""
    return {i: one_each(world, states, i) for i in range(len(world.sectors))}


LOOSE_FACES = (6, 7, 8)


def _loose(world: World, states: list[State]) -> dict[int, Proofs]:
    """The first face of the sheet once for each loose face, which belongs to the occluder."""
    proofs = one_each(world, states, 0)
    first = next(proof for proof in proofs.certificates if proof.targets == [SHEET_FACES[0]])
    proofs.uses[0] += range(len(proofs.certificates), len(proofs.certificates) + len(LOOSE_FACES))
    for face in LOOSE_FACES:
        proofs.certificates.append(Proof(first.region, first.targets, [[*WALL_FACES, face]]))
    return {0: proofs}


def _fine(world: World, states: list[State]) -> dict[int, Proofs]:
    return {0: one_each(world, states, 0, origin=(1024, -512, 7), subdivision=16)}


def _last_sector(world: World, states: list[State]) -> dict[int, Proofs]:
    return {1: one_each(world, states, 1)}


def with_cuts(world: World, states: list[State]) -> dict[int, Proofs]:
    """Certificates whose regions and targets are cut, as they need not be; every code occurs."""
    proofs = plain(world, states)
    for number, proof in enumerate(proofs[0].certificates):
        code = 1 + number % 6
        other = 1 + (number + 3) % 6
        # A cut, of whose first part another cut; three leaves.
        proof.cuts = [code, other, 0, 0, 0]
        proof.occluders = proof.occluders * 3
    return proofs


HIGH_WALL, LOW_WALL, BEHIND, TRIANGLE = [2, 3], [4, 5], (6, 7), 8


def fused(world: World, _states: list[State]) -> dict[int, Proofs]:
    """Certificates whose leaves have different occluders, so that the order of the parts counts."""
    proofs = Proofs((0, 2), [[0, 1], [2]], [])
    first, second = (region_of((cell,), proofs, world.exponent) for cell in world.cells)
    proofs.certificates += [Proof(first, [face], [HIGH_WALL, LOW_WALL], cuts=[3, 0, 0]) for face in BEHIND]
    # Edge 1 leads upwards from the corner 1, which the first part keeps.
    proofs.certificates.append(Proof(second, [TRIANGLE], [LOW_WALL, HIGH_WALL], cuts=[5, 0, 0]))
    return {0: proofs}


def _shared(world: World, states: list[State]) -> dict[int, Proofs]:
    """The east and the upper cell use the same certificates for what both do not see."""
    proofs = one_each(world, states, 0)
    region = region_of((world.cells[EAST], world.cells[UPPER]), proofs, world.exponent)
    kept = {}
    for index, proof in enumerate(proofs.certificates):
        target = proof.targets[0]
        if index in proofs.uses[UPPER]:
            common = next(i for i in proofs.uses[EAST] if proofs.certificates[i].targets == [target])
            proofs.certificates[common].region = region
            kept[index] = common
    proofs.uses[UPPER] = sorted(kept.values())
    proofs.certificates = proofs.certificates[: min(kept)]
    return {0: proofs}


def form_cases() -> Iterator[Case]:
    """Parts of the format: several targets, trees, cells that share, and files with nothing in them."""
    yield Case(
        "one-cell-proved",
        HIDING,
        "A wall hides a sheet of two faces, which one certificate has as targets, in a box.",
        "A checker that takes faces, and not their box, for several targets.",
        proofs=in_a_box,
    )
    yield Case(
        "nothing-to-prove",
        SINGLE,
        "A cell that sees everything, and a certificate file without a certificate.",
        "A checker that cannot take tables of length 0.",
        proofs=nothing,
    )
    yield Case(
        "ring-proved",
        RING,
        "The ring with a certificate of one leaf for every cell and every face that is hidden from it.",
        "A checker that asks for more than the conditions of the theorem.",
        near=("certificate/region-holds-cell", "certificate/complete"),
        proofs=plain,
    )
    yield Case(
        "cut-proofs",
        RING,
        "Trees with cuts of the region and of the target, across every axis and every edge.",
        "A checker that does not know one of the codes.",
        near=("certificate/tree",),
        proofs=with_cuts,
    )
    yield Case(
        "fused-proofs",
        FUSED,
        "Two walls hide faces together: a cut of the region and a cut of the target, with other occluders.",
        "A checker that takes the parts of a cut in the wrong order, or cuts the wrong edge.",
        proofs=fused,
    )
    yield Case(
        "loose-faces",
        LOOSE,
        "Occluders with a face more, whose edges are in nobody's way, each for another reason.",
        "A checker that lacks one of the tests that clear edges.",
        near=("certificate/sound",),
        proofs=_loose,
    )
    yield Case(
        "shared-proofs",
        RING,
        "Two cells use the same certificates, with a region that holds both.",
        "A checker that takes the region for the box of the cell.",
        proofs=_shared,
    )


def limit_cases() -> Iterator[Case]:
    """Limits that are only just kept, and certificates for a part of the tileset."""
    yield Case(
        "fine-proofs",
        RING,
        "Coordinates in units of a step divided by 2^16, some near 2^29, about an origin beside the scene.",
        "A checker that forgets the frame, or whose integers overflow.",
        near=("certificate/container",),
        proofs=_fine,
    )
    yield Case(
        "slanted-proofs",
        SLANTED,
        "Regions around cells that no box fits, rounded outwards.",
        "A checker that takes every cell for a box.",
        near=("certificate/region-holds-cell",),
        proofs=plain,
    )
    yield Case(
        "contact-proofs",
        CONTACT,
        "A region that touches its occluder.",
        "An overlap test that takes contact for intersection.",
        near=("certificate/sound",),
        proofs=plain,
    )
    yield Case(
        "one-sector-proved",
        TWO_SECTORS,
        "The ring in two nav files, with certificates for the second alone.",
        "A validator that calls the whole proved where a part is.",
        proofs=_last_sector,
    )


def proof_cases() -> Iterator[Case]:
    """All cases of this module."""
    yield from form_cases()
    yield from limit_cases()

"""Invalid certificate files: each breaks one of the requirements on them."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from casebuilder.edits import Edit, Edits, adding, dropping, edits, of_first, setting
from casebuilder.proofs import Maker, Proofs
from casebuilder.senses import BEHIND_THE_FENCE, FENCE_FACE
from casebuilder.state import State
from casebuilder.valid_proofs import (
    BUILDING_FACES,
    HIGH_WALL,
    SHEET_FACES,
    WALL_FACES,
    fused,
    in_a_box,
    plain,
)
from casebuilder.world import World
from casebuilder.worlds import FUSED, HIDING, PIERCED, RING, SLANTED, TWO_SECTORS, WEST

POSTER_FACE, FAR_SIDE = 4, 8
POST_FACES = list(range(6, 18))
CERTIFICATES = ("sectors", 0, "certificates")


def _made(change: Callable[[Proofs], object], make: Maker = plain, world: World = RING) -> Edits:
    """Edits of a case whose certificates of the first sector are changed."""

    def made(of: World, states: list[State]) -> dict[int, Proofs]:
        proofs = make(of, states)
        change(proofs[0])
        return proofs

    return edits(world=world, proofs=made)


def _small(change: Callable[[Proofs], object]) -> Edits:
    """The same for the one cell before a wall, with a certificate for each face of the sheet."""
    return _made(change, plain, HIDING)


def _boxed(change: Callable[[Proofs], object]) -> Edits:
    """The same with one certificate for both faces."""
    return _made(change, in_a_box, HIDING)


def _table(name: str, change: Callable[[Any], Any]) -> Edits:
    """Edits of a case in which a table of the certificate file is exchanged before it is laid out."""
    return _small(lambda proofs: proofs.changes.update({name: change}))


def _bytes(change: Callable[[bytes], bytes]) -> Edits:
    return edits(world=HIDING, proofs=plain, cert=change)


def _json(change: Edit) -> Edits:
    return edits(world=HIDING, proofs=plain, cert_json=of_first(change))


def _entry(change: Edit) -> Edits:
    return edits(world=HIDING, proofs=plain, entry=change)


FILES: dict[str, Edits] = {
    "certificate/file-resolves/missing": edits(world=HIDING, proofs=plain, files=dropping("nav/0.cert")),
    "certificate/file-resolves/wrong-digest": _entry(setting(*CERTIFICATES, "sha256", value="0" * 64)),
    "certificate/file-resolves/file-of-another-sector": edits(
        world=TWO_SECTORS, proofs=plain, entry=setting(*CERTIFICATES, "uri", value="nav/1.cert")
    ),
    "core/uri-inside/certificates-parent-folder": _entry(setting(*CERTIFICATES, "uri", value="../0.cert")),
    "core/entry-object/certificates-without-digest": _entry(dropping(*CERTIFICATES, "sha256")),
}


def _claim(data: bytes) -> bytes:
    return data[:16] + struct.pack("<Q", 10 * 2**30) + data[24:]


def _not_json(data: bytes) -> bytes:
    return data[:24] + b"[" + data[25:]


def _tabs(data: bytes) -> bytes:
    text = struct.unpack_from("<Q", data, 8)[0]
    head = data[:8] + struct.pack("<Q", text + 8) + data[16:24]
    return head + data[24 : 24 + text] + b"\t" * 8 + data[24 + text :]


def _overlap(part: Any) -> None:
    views, tables = part["bufferViews"], part["certificates"]
    views[tables["cutOffsets"]]["byteOffset"] = views[tables["targetOffsets"]]["byteOffset"]


def _share_view(part: Any) -> None:
    part["certificates"]["leaves"] = part["certificates"]["uses"]


def _region(change: Callable[[list[int]], None]) -> Callable[[Proofs], None]:
    """Change of the region of every certificate."""

    def edit(proofs: Proofs) -> None:
        for proof in proofs.certificates:
            region = list(proof.region)
            change(region)
            proof.region = tuple(region)

    return edit


def _flat(region: list[int]) -> None:
    region[5] = region[2]


def _far(region: list[int]) -> None:
    region[3] = 2**29


def _farther(proofs: Proofs) -> None:
    # The sheet is 4 m from the origin of this frame and the region, which lies about it, much nearer.
    proofs.origin = (3072, 0, 1024)
    proofs.subdivision = 17
    _region(lambda region: region.__setitem__(slice(0, 6), (-(2**28), -(2**28), -(2**27), 1, 2**28, 2**28)))(
        proofs
    )


def _first_proof(**members: Any) -> Callable[[Proofs], None]:
    """Change of members of the first certificate."""

    def edit(proofs: Proofs) -> None:
        for name, value in members.items():
            setattr(proofs.certificates[0], name, value)

    return edit


CONTAINER: dict[str, Edits] = {
    "certificate/container/magic": _bytes(lambda d: b"nav1" + d[4:]),
    "certificate/container/truncated": _bytes(lambda d: d[: len(d) // 2]),
    "certificate/container/empty-file": _bytes(lambda _: b""),
    "certificate/container/claims-10-gb": _bytes(_claim),
    "certificate/container/not-json": _bytes(_not_json),
    "certificate/container/padded-with-tabs": _bytes(_tabs),
    "certificate/container/no-frame": _json(dropping("frame")),
    "certificate/container/subdivision-of-30": _json(setting("frame", "subdivision", value=30)),
    "certificate/container/another-sector": _json(adding("sector", "firstCell", amount=1)),
    "certificate/container/overlapping-views": _json(_overlap),
    "certificate/container/shared-view": _json(_share_view),
    "certificate/container/huge-count": _json(setting("certificates", "targetCount", value=2**31)),
    "certificate/container/offsets-decrease": _table("cutOffsets", lambda t: t[[0, 2, 1]]),
    "certificate/container/offsets-end-too-early": _table("targetOffsets", lambda t: t - (t == t.max())),
    "certificate/container/big-endian": _table("uses", lambda t: t.astype(">u4")),
    "certificate/container/no-such-certificate": _small(lambda p: p.uses.__setitem__(0, [0, 1, 2])),
    "certificate/container/no-such-face": _small(_first_proof(targets=[6])),
    "certificate/container/no-such-occluder": _table("leaves", lambda t: t + 1),
    "certificate/container/uses-not-ascending": _small(lambda p: p.uses.__setitem__(0, [1, 0])),
    "certificate/container/targets-not-ascending": _boxed(_first_proof(targets=[5, 4])),
    "certificate/container/face-twice-in-an-occluder": _small(_first_proof(occluders=[[2, 2, 3]])),
    "certificate/container/no-target": _small(_first_proof(targets=[])),
    "certificate/container/empty-occluder": _small(_first_proof(occluders=[[]])),
    "certificate/container/flat-region": _small(_region(_flat)),
    "certificate/container/region-out-of-reach": _small(_region(_far)),
    "certificate/container/target-out-of-reach": _small(_farther),
}


def _shrink(region: list[int]) -> None:
    region[0] += 1


REGIONS: dict[str, Edits] = {
    "certificate/region-holds-cell/one-unit-short": _small(_region(_shrink)),
    "certificate/region-holds-cell/of-another-cell": _made(
        lambda p: p.certificates[p.uses[1][0]].__setattr__("region", p.certificates[0].region)
    ),
    "certificate/region-holds-cell/rounded-inwards": _made(_region(_shrink), plain, SLANTED),
}


def _odd_cut(proofs: Proofs) -> None:
    # The edge 0 becomes half as long with each cut, until its middle is no whole number.
    for proof in proofs.certificates:
        proof.cuts = [4] * 12 + [0] * 13
        proof.occluders = proof.occluders * 13


def _thin_cut(proofs: Proofs) -> None:
    for proof in proofs.certificates:
        proof.cuts = [1] * 13 + [0] * 14
        proof.occluders = proof.occluders * 14


TREES: dict[str, Edits] = {
    "certificate/tree/cut-short": _made(_first_proof(cuts=[3, 0]), fused, FUSED),
    "certificate/tree/goes-on": _small(_first_proof(cuts=[0, 0], occluders=[WALL_FACES] * 2)),
    "certificate/tree/empty": _small(_first_proof(cuts=[], occluders=[])),
    "certificate/tree/no-such-code": _small(_first_proof(cuts=[7])),
    "certificate/tree/box-of-several-targets-cut": _boxed(
        _first_proof(cuts=[4, 0, 0], occluders=[WALL_FACES] * 2)
    ),
    "certificate/tree/region-of-several-targets-cut": _boxed(
        _first_proof(cuts=[1, 0, 0], occluders=[WALL_FACES] * 2)
    ),
    "certificate/tree/cut-that-does-not-divide": _small(_thin_cut),
    "certificate/tree/middle-between-units": _small(_odd_cut),
    "certificate/tree/a-leaf-too-many": _small(_first_proof(occluders=[WALL_FACES] * 2)),
}


def _into_the_wall(region: list[int]) -> None:
    region[0] = -1


def _of_target(proofs: Proofs, target: int) -> Any:
    return next(proof for proof in proofs.certificates if proof.targets == [target])


def _even(proofs: Proofs) -> None:
    _of_target(proofs, POSTER_FACE).occluders = [BUILDING_FACES]


def _pierce(proofs: Proofs) -> None:
    proofs.certificates[0].occluders = [[*WALL_FACES, *POST_FACES]]


def _itself(proofs: Proofs) -> None:
    _of_target(proofs, FAR_SIDE).occluders = [BUILDING_FACES]


SOUND: dict[str, Edits] = {
    "certificate/sound/open-edge": _small(_first_proof(occluders=[WALL_FACES[:1]])),
    "certificate/sound/open-edge-before-a-box": _boxed(_first_proof(occluders=[WALL_FACES[:1]])),
    "certificate/sound/parts-exchanged": _made(
        lambda p: [proof.occluders.reverse() for proof in p.certificates], fused, FUSED
    ),
    "certificate/sound/one-wall-for-both-parts": _made(
        _first_proof(occluders=[HIGH_WALL, HIGH_WALL]), fused, FUSED
    ),
    "certificate/sound/even": _made(_even),
    "certificate/sound/its-own-occluder": _made(_itself),
    "certificate/sound/occluder-behind-the-target": _small(_first_proof(occluders=[SHEET_FACES[1:]])),
    "certificate/sound/occluder-through-the-target": _made(_pierce, plain, PIERCED),
    "certificate/sound/occluder-in-the-region": _small(_region(_into_the_wall)),
    "certificate/sound/porous-occluder": _made(
        _first_proof(occluders=[[FENCE_FACE, FENCE_FACE + 1]]), plain, BEHIND_THE_FENCE
    ),
    "certificate/sound/occluder-in-the-box": _boxed(_first_proof(targets=[2, 4, 5])),
}

COMPLETE: dict[str, Edits] = {
    "certificate/complete/certificate-not-used": _small(lambda p: p.uses.__setitem__(0, [0])),
    "certificate/complete/of-another-cell": _made(lambda p: p.uses[WEST].pop(0)),
    "certificate/complete/one-of-two-targets": _boxed(_first_proof(targets=[4])),
}

CASES = FILES | CONTAINER | REGIONS | TREES | SOUND | COMPLETE

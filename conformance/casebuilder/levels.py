"""Cases about coarse contents and their face maps."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from typing import Any

from casebuilder.assemble import Case
from casebuilder.coarse import Coarse, Maker, moved
from casebuilder.edits import Edit, Edits, adding, dropping, edits, setting
from casebuilder.world import World
from casebuilder.worlds import RING

RISE = 64
"""Grid steps by which a level is higher than the one below it."""


def two_levels(world: World) -> list[Coarse]:
    """Every content in a median and a coarse level."""
    return moved(world, RISE, levels=2)


def one_level(world: World) -> list[Coarse]:
    """Every content in a coarse level."""
    return moved(world, RISE)


def faces_for_many(world: World) -> list[Coarse]:
    """Every content in a coarse level in which a face stands for every face of its object."""
    made = one_level(world)
    for coarse in made:
        owners = [world.face_object[own[0]] for own in coarse.lists]
        faces = list(enumerate(world.face_object))
        coarse.lists = [[face for face, of in faces if of == owner] for owner in owners]
    return made


def level_cases() -> Iterator[Case]:
    """Valid cases."""
    yield Case(
        "two-coarse-levels",
        RING,
        "Median and coarse contents, each higher than the finer one by its error, with face maps.",
        "A reader that counts the faces of coarse levels, or shows all levels at once.",
        near=("level/chain", "level/error-holds"),
        coarse=two_levels,
    )
    yield Case(
        "faces-stand-for-many",
        RING,
        "A coarse level in which every face stands for every face of its object.",
        "A reader that takes the map for one of each face to one other.",
        coarse=faces_for_many,
    )


def _made(change: Callable[[Coarse], object], make: Maker = one_level, index: int = 0) -> Edits:
    """Edits of a case in which one coarse content is changed."""

    def made(world: World) -> list[Coarse]:
        found = make(world)
        change(found[index])
        return found

    return edits(coarse=made)


def _member(name: str, value: Any) -> Edits:
    return _made(lambda coarse: setattr(coarse, name, value))


def _table(name: str, change: Callable[[Any], Any]) -> Edits:
    return _made(lambda coarse: coarse.changes.update({name: change}))


def _bytes(change: Callable[[bytes], bytes]) -> Edits:
    return _member("data", change)


def _json(change: Edit) -> Edits:
    return _member("part", change)


def _tile(change: Edit) -> Edits:
    return _member("tile", change)


def _with(index: int, value: Any) -> Callable[[Any], Any]:
    """Change of one element of a table."""

    def change(table: Any) -> Any:
        table = table.copy()
        table[index] = value
        return table

    return change


def _one_face_more(coarse: Coarse) -> None:
    """A list more than the content has faces, and states."""
    coarse.lists.append([0])
    coarse.tile = adding("content", "extensions", "3DTILES_nav", "faceCount", amount=-1)


def _claim(data: bytes) -> bytes:
    return data[:16] + struct.pack("<Q", 10 * 2**30) + data[24:]


def _quarter_step(data: bytes) -> bytes:
    """Move a vertex of the binary chunk off the grid; the stated bounds are about the others."""
    start = 20 + struct.unpack_from("<I", data, 12)[0] + 8
    value = struct.unpack_from("<f", data, start)[0]
    return data[:start] + struct.pack("<f", value + 2.0**-12) + data[start + 4 :]


FACE_MAP = ("content", "extensions", "3DTILES_nav", "faceMap")

FILES: dict[str, Edits] = {
    "level/face-map-resolves/missing": edits(coarse=one_level, files=dropping("content/0-1.fmap")),
    "level/face-map-resolves/wrong-digest": _tile(setting(*FACE_MAP, "sha256", value="0" * 64)),
    "core/uri-inside/face-map-parent-folder": _tile(setting(*FACE_MAP, "uri", value="../0-1.fmap")),
    "core/content-object/face-map-without-digest": _tile(dropping(*FACE_MAP, "sha256")),
    "level/content-gltf/off-the-grid": _member("glb", _quarter_step),
    "level/content-gltf/not-gltf": _member("glb", lambda _: b"This is no binary glTF file.\n"),
}

CONTAINER: dict[str, Edits] = {
    "level/container/magic": _bytes(lambda d: b"nav1" + d[4:]),
    "level/container/truncated": _bytes(lambda d: d[: len(d) // 2]),
    "level/container/empty-file": _bytes(lambda _: b""),
    "level/container/claims-10-gb": _bytes(_claim),
    "level/container/not-json": _bytes(lambda d: d[:24] + b"[" + d[25:]),
    "level/container/no-errors": _json(dropping("faceMap", "errors")),
    "level/container/shared-view": _json(lambda p: p["faceMap"].update(faces=p["faceMap"]["objects"])),
    "level/container/other-face-count": _made(_one_face_more),
    "level/container/offsets-decrease": _table("offsets", lambda t: t[[0, 2, 1, *range(3, len(t))]]),
    "level/container/big-endian": _table("faces", lambda t: t.astype(">u4")),
    "level/container/no-such-face": _table("faces", _with(-1, len(RING.faces))),
    "level/container/no-such-object": _table("objects", _with(-1, len(RING.objects))),
    "level/container/faces-not-ascending": _made(lambda c: c.lists[0].append(c.lists[0][0])),
    "level/container/negative-error": _table("errors", _with(0, -1.0)),
    "level/container/error-not-a-number": _table("errors", _with(0, float("nan"))),
}


def _missing_content(world: World) -> list[Coarse]:
    return one_level(world)[:1]


def _exchanged(coarse: Coarse) -> None:
    coarse.lists[0], coarse.lists[-1] = coarse.lists[-1], coarse.lists[0]


def _empty(coarse: Coarse) -> None:
    coarse.lists[1] = [*coarse.lists[0], *coarse.lists[1]]
    coarse.lists[0] = []


def _twice(coarse: Coarse) -> None:
    coarse.lists[1] = coarse.lists[0]


def _last_face_too(coarse: Coarse) -> None:
    coarse.lists[0].append(coarse.lists[-1][0])


def _largest_below(world: World) -> list[Coarse]:
    """Two levels, the finer of which has no face maps and claims to be the third."""
    made = two_levels(world)

    def third(tile: Any) -> None:
        facts = tile["content"]["extensions"]["3DTILES_nav"]
        facts["level"] = 3
        del facts["faceMap"]

    for coarse in made:
        if coarse.level == 1:
            coarse.tile = third
    return made


def _crossed(tileset: Any) -> None:
    """Exchange what is below two coarse tiles, whose volumes hold both."""
    first, second = tileset["root"]["children"]
    first["children"], second["children"] = second["children"], first["children"]
    for tile in (first, second):
        tile["boundingVolume"] = tileset["root"]["boundingVolume"]


OBJECTS: dict[str, Edits] = {
    "level/objects-whole/content-id-gap": _made(lambda c: setattr(c, "content_id", 2), index=1),
    "level/objects-whole/content-without-its-level": edits(coarse=_missing_content),
    "level/faces-covered/stands-for-nothing": _made(_empty),
    "level/faces-covered/not-stood-for": _made(_twice),
    "level/faces-covered/face-of-another-object": _made(_last_face_too),
}

CHAIN: dict[str, Edits] = {
    "level/chain/refine-add": _tile(setting("refine", value="ADD")),
    "level/chain/error-understated": _tile(adding("geometricError", amount=-(2.0**-10))),
    "level/chain/less-than-a-finer-tile": _made(
        lambda c: setattr(c, "tile", adding("geometricError", amount=1.0)), two_levels
    ),
    "level/chain/larger-level-below": edits(coarse=_largest_below),
    "level/chain/other-objects-below": edits(coarse=one_level, tileset=_crossed),
}

ERRORS: dict[str, Edits] = {
    "level/error-holds/understated": _table("errors", lambda t: t - 2.0**-10),
    "level/error-holds/other-faces-of-the-object": _made(_exchanged, index=1),
}

CASES = FILES | CONTAINER | OBJECTS | CHAIN | ERRORS

"""Stage binary: what is in the contents."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tilesnav_validator import glb, volumes
from tilesnav_validator.checks import check
from tilesnav_validator.checks.links import accumulated
from tilesnav_validator.findings import Finding
from tilesnav_validator.subject import Subject
from tilesnav_validator.tiles import EXTENSION, Content

MAX_STEPS = 2**23


@check("core/content-gltf", needs=("core/content-ids-dense", "core/content-digest"))
def content_gltf(subject: Subject) -> Iterator[Finding]:
    """Every content of level 0 can be read without a decoder."""
    for content in subject.finest:
        assert content.data is not None
        try:
            glb.read(content.data)
        except glb.GlbError as error:
            yield Finding(f"{content.place} glTF {error.where}", error.measured, error.allowed)


@check("core/object-flags")
def object_flags(subject: Subject) -> Iterator[Finding]:
    """Indices of primitives that are porous or one-sided."""
    for content in subject.walk.contents:
        for member in ("porous", "oneSided"):
            before = -1
            for place, index in enumerate(content.nav.get(member, [])):
                if not before < index < content.nav["objectCount"]:
                    where = f"{content.place}/extensions/{EXTENSION}/{member}/{place}"
                    allowed = f"greater than {before}, less than {content.nav['objectCount']}"
                    yield Finding(where, str(index), allowed)
                before = max(before, index)


@check("core/on-grid", needs=("core/content-gltf",))
def on_grid(subject: Subject) -> Iterator[Finding]:
    """Positions are multiples of the grid step."""
    for content, primitives in zip(subject.finest, subject.primitives, strict=True):
        yield from position_faults(content, primitives, subject.step)


def position_faults(
    content: Content, primitives: Sequence[glb.Primitive], step: float
) -> Iterator[Finding]:
    """Positions of a content that are off the grid, or too far."""
    for number, primitive in enumerate(primitives):
        steps = primitive.positions / step
        wrong = (steps != np.rint(steps)) | (np.abs(steps) >= MAX_STEPS)
        for vertex in np.flatnonzero(wrong.any(axis=1)):
            measured = f"{primitive.positions[vertex].tolist()} (nav frame)"
            allowed = f"integer multiples of {step:g}, less than 2^23 of them"
            yield Finding(f"{content.place} primitive {number} vertex {vertex}", measured, allowed)


@check("core/face-count", needs=("core/content-gltf",))
def face_count(subject: Subject) -> Iterator[Finding]:
    """Counts of the contents, then their sums, which say nothing new where a content of level 0 is wrong."""
    totals = {"faceCount": 0, "objectCount": 0}
    wrong = False
    for content, primitives in zip(subject.finest, subject.primitives, strict=True):
        for finding in _wrong_counts(content, primitives):
            wrong = True
            yield finding
        for name, count in _counts(primitives).items():
            totals[name] += count
    for content in subject.walk.contents:
        coarse = _decoded(content) if content.nav["level"] != 0 else None
        if coarse is not None:
            yield from _wrong_counts(content, coarse)
    for name, count in totals.items():
        if not wrong and subject.nav[name] != count:
            where = f"{subject.entry_name}#/extensions/{EXTENSION}/{name}"
            yield Finding(where, str(subject.nav[name]), f"{count}, counted")


def _counts(primitives: Sequence[glb.Primitive]) -> dict[str, int]:
    return {"faceCount": sum(len(part.triangles) for part in primitives), "objectCount": len(primitives)}


def _wrong_counts(content: Content, primitives: Sequence[glb.Primitive]) -> Iterator[Finding]:
    for name, count in _counts(primitives).items():
        if content.nav[name] != count:
            where = f"{content.place}/extensions/{EXTENSION}/{name}"
            yield Finding(where, str(content.nav[name]), f"{count}, counted")


@check("core/tile-volume-bounds", needs=("core/on-grid", "core/content-transform"))
def tile_volume_bounds(subject: Subject) -> Iterator[Finding]:
    """Volumes of the tiles above every nav content."""
    reported = set()
    for content in subject.walk.contents:
        primitives = _decoded(content)
        if primitives is None:
            continue
        positions = np.concatenate([np.zeros((0, 3)), *(part.positions for part in primitives)])
        to_tile = np.eye(4)
        for tile in content.tile.chain():
            local = positions @ to_tile[:3, :3].T + to_tile[:3, 3]
            product = accumulated(tile)
            assert product is not None
            assert tile.transform is not None
            fault = volumes.fault(tile.volume, local, product, subject.step)
            if fault and tile.place not in reported:
                reported.add(tile.place)
                yield Finding(
                    f"{tile.place}/boundingVolume", fault, f"at most {subject.step:g} m, for {content.place}"
                )
            to_tile = tile.transform @ to_tile


def _decoded(content: Content) -> list[glb.Primitive] | None:
    """Primitives of a content; None for a coarse one that this reader does not understand."""
    assert content.data is not None
    try:
        return glb.read(content.data)
    except glb.GlbError:
        return None

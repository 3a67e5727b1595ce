"""Stage link: uris, external tilesets, transforms, numbering of contents, digests of contents."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from tilesnav_validator.checks import check
from tilesnav_validator.findings import Finding
from tilesnav_validator.subject import Subject
from tilesnav_validator.tiles import EXTENSION, Tile, as_transform

RIGID = 1e-9
CONTENT_TRANSFORM = 1e-6
LINKED = ("core/uri-inside", "core/content-resolves", "core/external-tilesets-end")
"""What must hold before the list of contents is known to be whole."""


@check("core/uri-inside")
def uri_inside(subject: Subject) -> Iterator[Finding]:
    """Uris of sectors, certificate files, face maps, contents and external tilesets."""
    yield from subject.walk.faults["core/uri-inside"]
    _ = subject.sectors, subject.certificate_files, subject.coarse
    yield from subject.sector_faults["core/uri-inside"]


@check("core/sector-resolves")
def sector_resolves(subject: Subject) -> Iterator[Finding]:
    """Sectors that could not be opened."""
    _ = subject.sectors
    yield from subject.sector_faults["core/sector-resolves"]


@check("core/content-resolves")
def content_resolves(subject: Subject) -> Iterator[Finding]:
    """Contents that could not be opened."""
    yield from subject.walk.faults["core/content-resolves"]


@check("core/external-tilesets-end")
def external_tilesets_end(subject: Subject) -> Iterator[Finding]:
    """Circles and depth of external tilesets."""
    yield from subject.walk.faults["core/external-tilesets-end"]


@check("core/transform-rigid")
def transform_rigid(subject: Subject) -> Iterator[Finding]:
    """The transform of the nav frame."""
    where = f"{subject.entry_name}#/extensions/{EXTENSION}/transform"
    matrix = as_transform(subject.nav["transform"])
    if matrix is None:
        yield Finding(where, "numbers that do not fit a float64", "finite numbers")
        return
    if matrix[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        yield Finding(where, f"last row {matrix[3].tolist()}", "0 0 0 1")
        return
    rotation = matrix[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        off = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if not off <= RIGID:
        yield Finding(where, f"off orthonormal by {off:.3g}", f"at most {RIGID:g}")
    elif np.linalg.det(rotation) < 0:
        yield Finding(where, "determinant -1", "+1")


def accumulated(tile: Tile) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]] | None:
    """Product of the transforms from the root to a tile, None when one of them is malformed."""
    product = np.eye(4)
    for link in tile.chain():
        if link.transform is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            product = link.transform @ product
    return product


@check("core/content-transform", needs=("core/transform-rigid",))
def content_transform(subject: Subject) -> Iterator[Finding]:
    """Transforms of the tiles above nav contents."""
    wanted = as_transform(subject.nav["transform"])
    assert wanted is not None
    for content in subject.walk.contents:
        product = accumulated(content.tile)
        if product is None:
            broken = next(tile for tile in content.tile.chain() if tile.transform is None)
            yield Finding(f"{broken.place}/transform", "malformed", "16 finite numbers")
            continue
        off = float(np.abs(product - wanted).max())
        if not off <= CONTENT_TRANSFORM:
            yield Finding(
                content.tile.place,
                f"product of transforms off by {off:.3g}",
                f"at most {CONTENT_TRANSFORM:g}",
            )


@check("core/content-ids-dense", needs=LINKED)
def content_ids_dense(subject: Subject) -> Iterator[Finding]:
    """Numbering of the contents of level 0."""
    for expected, content in enumerate(subject.finest):
        found = int(content.nav["contentId"])
        if found != expected:
            yield Finding(f"{content.place}/extensions/{EXTENSION}/contentId", str(found), str(expected))
            return


@check("core/content-digest", needs=LINKED)
def content_digest(subject: Subject) -> Iterator[Finding]:
    """SHA-256 of every nav content."""
    for content in subject.walk.contents:
        assert content.data is not None
        digest = hashlib.sha256(content.data).hexdigest()
        if content.nav["sha256"] != digest:
            stated = str(content.nav["sha256"])[:80]
            yield Finding(f"{content.place}/extensions/{EXTENSION}/sha256", stated, digest)

"""States of cells: sorted faces, counts, digests, objects and codes, totals."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from tilesnav_validator import ragged
from tilesnav_validator.checks import check
from tilesnav_validator.checks.cells import FACES
from tilesnav_validator.checks.container import WHOLE
from tilesnav_validator.findings import Finding
from tilesnav_validator.subject import Subject
from tilesnav_validator.tiles import EXTENSION


@check("pvs/sorted-faces", needs=(*WHOLE, "core/face-count"))
def sorted_faces(subject: Subject) -> Iterator[Finding]:
    """Faces of a PVS are in range and ascend."""
    faces, limit = subject.tables.faces, subject.number("faceCount")
    cells = ragged.rows(faces.offsets)
    out = faces.values >= limit
    for index in np.flatnonzero(out):
        yield Finding(
            f"cell {cells[index]} pvs/faces[{index}]", str(faces.values[index]), f"less than {limit}"
        )
    for index in ragged.not_ascending(faces.values, faces.offsets):
        if not out[index] and not out[index - 1]:
            measured = f"{faces.values[index]} after {faces.values[index - 1]}"
            yield Finding(f"cell {cells[index]} pvs/faces[{index}]", measured, "strictly ascending")


@check("pvs/proven-within-listed", needs=WHOLE)
def proven_within_listed(subject: Subject) -> Iterator[Finding]:
    """No more faces are proven than listed."""
    listed = np.diff(subject.tables.faces.offsets)
    for cell in np.flatnonzero(subject.tables.proven > listed):
        yield Finding(
            f"cell {cell}", f"{subject.tables.proven[cell]} proven", f"at most {listed[cell]}, those listed"
        )


@check("pvs/digest", needs=WHOLE)
def digest(subject: Subject) -> Iterator[Finding]:
    """Digests of the canonical bytes of the states."""
    tables = subject.tables
    for cell in range(tables.cell_count):
        state = hashlib.sha256()
        for part in (tables.faces.row(cell), tables.objects.row(cell)):
            state.update(len(part).to_bytes(4, "little"))
            state.update(part.astype("<u4").tobytes())
        state.update(tables.codes.row(cell).tobytes())
        if state.digest() != tables.digests[cell].tobytes():
            yield Finding(f"cell {cell}", tables.digests[cell].tobytes().hex(), state.hexdigest())


@check("lod/objects-match", needs=("pvs/sorted-faces", *FACES))
def objects_match(subject: Subject) -> Iterator[Finding]:
    """Objects of a cell are those of its faces."""
    tables, objects = subject.tables, subject.faces.objects
    for cell in range(tables.cell_count):
        wanted = np.unique(objects[tables.faces.row(cell)])
        found = tables.objects.row(cell)
        if not np.array_equal(found, wanted):
            missing, extra = (
                np.setdiff1d(wanted, found)[:5].tolist(),
                np.setdiff1d(found, wanted)[:5].tolist(),
            )
            order = "" if missing or extra else ", not in ascending order"
            yield Finding(
                f"cell {cell}", f"missing {missing}, too many {extra}{order}", f"{len(wanted)} objects"
            )


@check("lod/code-range", needs=WHOLE)
def code_range(subject: Subject) -> Iterator[Finding]:
    """Codes are on the scale."""
    codes, limit = subject.tables.codes, int(subject.nav["lod"]["levelCount"])
    cells = ragged.rows(codes.offsets)
    for index in np.flatnonzero(codes.values >= limit):
        yield Finding(
            f"cell {cells[index]} lod/codes[{index}]", str(codes.values[index]), f"less than {limit}"
        )


@check("provenance/totals", needs=WHOLE)
def totals(subject: Subject) -> Iterator[Finding]:
    """Sums over all cells."""
    sums = {
        "listed": int(subject.tables.faces.offsets[-1]),
        "provenVisible": int(subject.tables.proven.sum()),
    }
    for name, total in sums.items():
        if subject.nav["pvs"][name] != total:
            where = f"{subject.entry_name}#/extensions/{EXTENSION}/pvs/{name}"
            yield Finding(where, str(subject.nav["pvs"][name]), f"{total}, the sum over all cells")

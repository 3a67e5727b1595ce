"""The PVS against rays: a search for faces that are visible and not listed."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilesnav_validator import exact, rays
from tilesnav_validator.checks import check
from tilesnav_validator.checks.cells import FACES, NO_CELL
from tilesnav_validator.findings import Finding, Findings, NotRefuted, NotRun
from tilesnav_validator.subject import Subject

NO_RAYS = "no rays asked for"

ENOUGH = 100
"""Confirmed faces after which the search ends: the tileset is invalid, and its encoder has enough to look
at."""


@check("pvs/conservative", needs=("pvs/sorted-faces", "core/object-flags", "cell/unit-normals", *FACES))
def conservative(subject: Subject) -> Findings:
    """Rays from sound cells; every apparent hit on an unlisted face is decided exactly."""
    cells = np.flatnonzero(subject.sound_cells).astype(np.int64)
    wanted = subject.settings.rays
    if not len(cells):
        return NO_CELL
    if not wanted:
        return NotRun(NO_RAYS)
    caster = rays.Caster(
        subject.faces,
        subject.polyhedra,
        subject.tables.faces,
        subject.step,
        subject.settings.seed,
        subject.max_range,
    )
    chunks = rays.plan(cells, wanted, len(subject.faces.objects), subject.settings.seed)
    tally = Tally()
    for catch in rays.cast_all(caster, chunks, subject.settings.threads):
        tally.cast(catch.chunk)
        for candidate in catch.candidates:
            witness = tally.decide(subject, candidate, catch.chunk.aimed)
            if witness:
                yield _finding(witness)
        if len(tally.confirmed) >= ENOUGH:
            break
    subject.search = tally.report(len(cells))
    return NotRefuted(f"{tally.uniform + tally.aimed} rays, seed {subject.settings.seed}")


class Tally:
    """Counts of a search."""

    def __init__(self) -> None:
        self.uniform = self.aimed = self.candidates = 0
        self.confirmed: set[tuple[int, int]] = set()
        self.by_uniform = False

    def cast(self, chunk: rays.Chunk) -> None:
        """Count the rays of a chunk."""
        if chunk.aimed:
            self.aimed += int(chunk.counts.sum())
        else:
            self.uniform += int(chunk.counts.sum())

    def decide(self, subject: Subject, candidate: exact.Candidate, aimed: bool) -> exact.Witness | None:
        """Decide a candidate unless its cell and face have a witness already."""
        pair = candidate.cell, candidate.face
        self.candidates += 1
        if pair in self.confirmed:
            return None
        planes = subject.tables.planes[candidate.cell]
        witness = exact.decide(candidate, planes, subject.faces, subject.step, subject.max_range)
        if witness:
            self.confirmed.add(pair)
            self.by_uniform |= not aimed
        return witness

    def report(self, cells: int) -> dict[str, Any]:
        """What the search may claim. The bound is the rule of three, for the uniform rays alone."""
        search: dict[str, Any] = {
            "uniformRays": self.uniform,
            "aimedRays": self.aimed,
            "cells": cells,
            "candidates": self.candidates,
            "confirmed": len(self.confirmed),
        }
        counts = f"{self.uniform} uniform and {self.aimed} aimed rays from {cells} cells"
        if self.by_uniform or not self.uniform:
            return search | {
                "statement": f"search: {counts}; {len(self.confirmed)} missing faces confirmed exactly"
            }
        bound = 3 / self.uniform
        claim = (
            "with 95 % confidence, of all pairs of a position in a cell (all cells alike) and a direction, "
            f"at most {bound:.3g} see a missing face"
        )
        return search | {
            "confidence": 0.95,
            "missedShareAtMost": bound,
            "statement": f"search: {counts}; {claim}",
        }


def _finding(witness: exact.Witness) -> Finding:
    numbers = {name: [str(x) for x in value] for name, value in (("c", witness.c), ("t", witness.t))}
    c, t = ([float(x) for x in value] for value in (witness.c, witness.t))
    where = f"cell {witness.cell} face {witness.face}"
    measured = f"not listed, but {t} on it is seen from {c}"
    return Finding(where, measured, "listed", {"cell": witness.cell, "face": witness.face, **numbers})

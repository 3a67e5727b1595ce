"""Level codes: fine enough, and not wasteful."""

from __future__ import annotations

from tilesnav_validator.checks import check
from tilesnav_validator.checks.cells import NO_CELL
from tilesnav_validator.findings import Finding, Findings, NotRefuted
from tilesnav_validator.lodjudge import Fault
from tilesnav_validator.subject import Subject

_NEEDS = ("lod/objects-match", "lod/code-range", "cell/unit-normals")


def _findings(subject: Subject, faults: list[Fault], undecided: int, allowed: str) -> Findings:
    tables, levels = subject.tables, subject.levels
    for fault in faults:
        item, code = tables.objects.values[fault.entry], tables.codes.values[fault.entry]
        where = f"cell {fault.cell} object {item} code {code}"
        yield Finding(
            where,
            f"largest L from {fault.low:.9g} to {fault.high:.9g} 1/m",
            f"{allowed} {fault.limit:.9g} 1/m",
        )
    if not levels.cells:
        return NO_CELL
    if undecided or levels.cells < levels.of_cells:
        looked = f"{levels.cells} of {levels.of_cells} cells, {undecided} codes undecided"
        return NotRefuted(f"{looked}, seed {subject.settings.seed}")
    return None


@check("lod/fine-enough", needs=_NEEDS)
def fine_enough(subject: Subject) -> Findings:
    """No code is greater than that of the largest L."""
    return (yield from _findings(subject, subject.levels.coarse, subject.levels.open_coarse, "at most"))


@check("lod/not-wasteful", needs=_NEEDS)
def not_wasteful(subject: Subject) -> Findings:
    """No code is less than that of the largest L minus one."""
    return (yield from _findings(subject, subject.levels.wasteful, subject.levels.open_wasteful, "more than"))

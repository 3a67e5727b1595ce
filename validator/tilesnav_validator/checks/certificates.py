"""Certificates: files, containers, regions, trees, and the proofs themselves."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from functools import wraps

import numpy as np

from tilesnav_validator import certfile, cuttrees, proofs, regions
from tilesnav_validator.checks import check
from tilesnav_validator.checks.cells import FACES
from tilesnav_validator.checks.container import WHOLE, offset_faults, table_faults, view_faults
from tilesnav_validator.findings import Finding, Findings, NotRun, Outcome
from tilesnav_validator.navfile import NavFile
from tilesnav_validator.ragged import take
from tilesnav_validator.subject import Subject

IDS = tuple(
    f"certificate/{name}"
    for name in ("file-resolves", "container", "region-holds-cell", "tree", "sound", "complete")
)
"""What has to pass before the sets of a tileset count as proved."""


def _timed(run: Callable[[Subject], Findings]) -> Callable[[Subject], Findings]:
    """A check whose time is added to that of the proof; where no sector has certificates there is none."""

    @wraps(run)
    def timed(subject: Subject) -> Findings:
        started = time.perf_counter()
        outcome = yield from run(subject)
        if subject.certificate_files:
            spent = subject.proof.get("seconds", 0.0) + time.perf_counter() - started
            subject.proof["seconds"] = round(spent, 4)
        return outcome

    return timed


@check("certificate/file-resolves", needs=("core/uri-inside",))
def file_resolves(subject: Subject) -> Generator[Finding, None, None]:
    """Certificate files that could not be opened, or are others than those meant."""
    _ = subject.certificate_files
    yield from subject.sector_faults["certificate/file-resolves"]


@check("certificate/container", needs=("certificate/file-resolves", *WHOLE, *FACES))
@_timed
def container(subject: Subject) -> Findings:
    """Header, JSON part, tables and numbers; the schema has been judged before."""
    whole = True
    for index, file in subject.certificate_files.items():
        for finding in _container_faults(subject, index, file):
            whole = False
            yield finding
    if subject.certificate_files and whole:
        files, found = subject.certificate_files.values(), subject.certificates.values()
        subject.proof |= {
            "files": len(files),
            "certificates": sum(len(one.regions) for one in found),
            "leaves": sum(len(one.leaves) for one in found),
            "bytes": sum(len(file.data) for file in files),
        }
    return None


def _container_faults(subject: Subject, index: int, file: NavFile) -> Findings:
    """Faults of one file, those of a kind only where the kinds before have none."""
    fault = file.header_fault()
    if fault:
        yield fault
        return None
    clean = True
    for kind in (NavFile.padding_faults, view_faults, table_faults, offset_faults):
        for finding in kind(file):
            clean = False
            yield finding
        if not clean:
            return None
    stated = subject.nav["sectors"][index]
    for name in ("firstCell", "cellCount"):
        if file.json["sector"][name] != stated[name]:
            measured = str(file.json["sector"][name])
            yield Finding(f"{file.name}#/sector/{name}", measured, f"{stated[name]}, that of the sector")
            clean = False
    if clean:
        found = certfile.read(file)
        yield from _number_faults(subject, found)
    return None


def _number_faults(subject: Subject, found: certfile.Certificates) -> Findings:
    clean = True
    for finding in certfile.number_faults(found, subject.number("faceCount")):
        clean = False
        yield finding
    if clean:
        yield from certfile.coordinate_faults(found, subject.faces.grid)
    return None


@check("certificate/region-holds-cell", needs=("certificate/container", "cell/bounded"))
@_timed
def region_holds_cell(subject: Subject) -> Findings:
    """Exact corners of the cells against the closed regions."""
    for found in subject.certificates.values():
        for row in range(len(found.uses.offsets) - 1):
            used = found.uses.row(row)
            cell = found.first_cell + row
            corners = regions.corners(subject.tables.planes[cell], found, subject.nav["grid"]["exponent"])
            for index, measured in regions.outside(corners, found.regions[used], found.shapes[used]):
                where = f"{found.name} certificate {used[index]} cell {cell}"
                yield Finding(where, measured, "within the closed region")
    return None


@check("certificate/tree", needs=("certificate/container",))
@_timed
def tree(subject: Subject) -> Findings:
    """Every tree by itself, then the number of leaves of all."""
    for found in subject.certificates.values():
        scene = proofs.Scene(found, subject.faces)
        clean = True
        for certificate in np.flatnonzero(~scene.is_leaf):
            try:
                for _ in scene.tree(int(certificate)):
                    pass
            except cuttrees.TreeError as error:
                clean = False
                yield Finding(f"{found.name} certificate {certificate}", str(error), "a complete tree")
        leaves = int(scene.first_leaf[-1])
        if clean and leaves != len(found.leaves):
            yield Finding(f"{found.name} leaves", str(len(found.leaves)), f"{leaves}, those of the trees")
    return None


@check("certificate/sound", needs=("certificate/tree",))
@_timed
def sound(subject: Subject) -> Findings:
    """The conditions of the parity theorem for every leaf."""
    for index, found in subject.certificates.items():
        sizes = np.diff(found.occluders.offsets)
        outcome = _too_much(subject, found, int(sizes[found.leaves].sum()))
        if outcome:
            return outcome
        scene = proofs.Scene(found, subject.faces)
        random = np.random.default_rng([subject.settings.seed, 5, index])
        yield from proofs.flat_targets(scene)
        for batch in proofs.batches(scene):
            yield from proofs.faults(scene, batch, random)
    return None


def _too_much(subject: Subject, found: certfile.Certificates, pairs: int) -> Outcome:
    limit = subject.settings.proof_pairs
    return NotRun(f"{found.name}: {pairs} pairs to look at, more than {limit}") if pairs > limit else None


@check("certificate/complete", needs=("certificate/container", "pvs/sorted-faces"))
@_timed
def complete(subject: Subject) -> Findings:
    """Faces that a cell neither lists nor has as targets."""
    for found in subject.certificates.values():
        sizes = np.diff(found.targets.offsets)
        outcome = _too_much(subject, found, int(sizes[found.uses.values].sum()))
        if outcome:
            return outcome
        for row in range(len(found.uses.offsets) - 1):
            cell = found.first_cell + row
            rest = subject.faces.sound.copy()
            rest[subject.tables.faces.row(cell)] = False
            _, index = take(found.targets.offsets, found.uses.row(row))
            rest[found.targets.values[index]] = False
            for face in np.flatnonzero(rest):
                yield Finding(f"cell {cell} face {face}", "neither listed nor a target", "one of both")
    return None

"""Running the checks in order of stages, each only where what it rests on has passed."""

from __future__ import annotations

import logging
import time
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

import numpy as np

from tilesnav_validator import schemarules, strictjson
from tilesnav_validator.checks import Registered, certificates, registered
from tilesnav_validator.checks.conservative import NO_RAYS
from tilesnav_validator.checks.packets import CLASS as PACKET
from tilesnav_validator.findings import Finding, Findings, NotRefuted, NotRun, Settings
from tilesnav_validator.navfile import NavFile
from tilesnav_validator.registry import REGISTRY, STAGES, Requirement
from tilesnav_validator.subject import Subject
from tilesnav_validator.tiles import EXTENSION

MAX_FINDINGS = 20
"""Findings of a requirement that are kept; the others are counted."""

_log = logging.getLogger(__name__)


@dataclass
class Judgement:
    """The verdict on one requirement.

    Attributes
    ----------
    verdict : str
        ``pass``, ``fail``, ``not run``, ``not refuted`` or ``proved``.
    note : str
        Why it was not run, or the size of the search.
    findings : list of Finding
        The first ``MAX_FINDINGS``.
    count : int
        Number of all findings.
    """

    requirement: Requirement
    verdict: str
    note: str = ""
    findings: list[Finding] = field(default_factory=list)
    count: int = 0


@dataclass
class Result:
    """Everything that a run has found out."""

    subject: Subject
    judgements: list[Judgement]
    seconds: dict[str, float]

    @property
    def valid(self) -> bool:
        """Whether no requirement of severity ``error`` has failed."""
        return not any(j.verdict == "fail" and j.requirement.severity == "error" for j in self.judgements)

    @property
    def not_examined(self) -> list[str]:
        """Ids of the requirements that were not run."""
        return [j.requirement.id for j in self.judgements if j.verdict == "not run"]

    @property
    def verdict(self) -> str:
        """``valid``, ``invalid``, or ``incomplete`` where nothing failed and not everything was examined."""
        if not self.valid:
            return "invalid"
        return "incomplete" if self.not_examined else "valid"


def judge(path: Path, settings: Settings) -> Result:
    """Judge a tileset.

    Parameters
    ----------
    path : Path
        The entry tileset.
    settings : Settings

    Raises
    ------
    UnreadableInputError
        If the entry tileset cannot be read at all.
    """
    seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
    started = time.perf_counter()
    with np.errstate(
        all="ignore"
    ):  # hostile numbers overflow; comparisons are written so that NaN is a finding
        subject = Subject(path, settings)
        seconds["io"] = time.perf_counter() - started
        run = _Run(subject)
        for identifier in _asked_for(settings):
            started = time.perf_counter()
            run.judge(REGISTRY[identifier])
            seconds[REGISTRY[identifier].stage] += time.perf_counter() - started
            _log.debug("%s: %s", identifier, run.done[identifier].verdict)
        run.prove()
    return Result(subject, [run.done[i] for i in REGISTRY if i in run.done], seconds)


def _asked_for(settings: Settings) -> list[str]:
    """Ids in the order in which they are judged: all about the tileset, then packets if there are some."""
    of_packets = [identifier for identifier in order() if _is_packet(identifier)]
    of_tileset = [identifier for identifier in order() if identifier not in of_packets]
    return of_tileset + (of_packets if settings.packets else [])


def order() -> list[str]:
    """Ids in the order in which they are judged: by stage, and after what they need."""
    checks = registered()
    pending = sorted(REGISTRY, key=lambda identifier: STAGES.index(REGISTRY[identifier].stage))
    ordered: list[str] = []
    while pending:
        ready = next(i for i in pending if all(need in ordered for need in _needs(i, checks)))
        ordered.append(ready)
        pending.remove(ready)
    return ordered


def _needs(identifier: str, checks: dict[str, Registered]) -> tuple[str, ...]:
    """What must have passed: what the check names, and the stage schema for all that comes later."""
    if REGISTRY[identifier].stage == "schema":
        return ()
    first = tuple(row.id for row in REGISTRY.values() if row.stage == "schema")
    if identifier == "container/json":
        return (*first, "container/header")
    return first + checks[identifier].needs


class _Run:
    """State of one run: the verdicts so far and the schema errors by requirement."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.checks = registered()
        self.done: dict[str, Judgement] = {}
        self.schema_errors: dict[str, list[Finding]] = defaultdict(list)
        self._validate(subject.entry, "entry-tileset.schema.json", f"{subject.entry_name}#")
        for content in subject.walk.contents:
            where = f"{content.place}/extensions/{EXTENSION}"
            self._validate(content.nav, "content.3DTILES_nav.schema.json", where)

    def _validate(self, document: object, name: str, where: str) -> None:
        for identifier, finding in schemarules.errors(document, name, where):
            self.schema_errors[identifier].append(finding)

    def judge(self, requirement: Requirement) -> None:
        """Find the verdict on a requirement; what it needs has been judged before."""
        failed = [need for need in self._rests_on(requirement) if self.done[need].verdict not in _GOOD]
        if failed:
            first = next((need for need in failed if self.done[need].verdict == "fail"), failed[0])
            self.done[requirement.id] = Judgement(
                requirement, "not run", f"{first}: {self.done[first].verdict}"
            )
            return
        self.done[requirement.id] = _collect(requirement, self._findings(requirement))

    def _rests_on(self, requirement: Requirement) -> list[str]:
        """What has to have passed; for packets, all of their tileset that has not been left out."""
        needs = list(_needs(requirement.id, self.checks))
        if _is_packet(requirement.id):
            needs += [i for i, one in self.done.items() if one.verdict == "fail" and not _is_packet(i)]
        return needs

    def _findings(self, requirement: Requirement) -> Findings:
        if requirement.id == "container/json":
            self._read_json("container/json", self.subject.sectors, "nav.schema.json")
        if requirement.id == "certificate/container":
            files = [file for file in self.subject.certificate_files.values() if not file.header_fault()]
            self._read_json("certificate/container", files, "certificates.schema.json")
        if requirement.id == "level/container":
            maps = [coarse.file for coarse in self.subject.coarse if not coarse.file.header_fault()]
            self._read_json("level/container", maps, "facemap.schema.json")
        found = self.schema_errors.pop(requirement.id, [])
        yield from found
        if requirement.checked_by == "schema" or found:
            return self._absent(_MEMBERS.get(requirement.id))
        outcome = yield from cast(Findings, self.checks[requirement.id].run(self.subject))
        return outcome

    def _absent(self, member: str | None) -> NotRun | None:
        """Whether the member of the entry object that a requirement is about is missing."""
        node: object = self.subject.entry
        for name in () if member is None else ("extensions", EXTENSION, member):
            if not isinstance(node, dict) or name not in node:
                return NotRun(f"no {name}")
            node = node[name]
        return None

    def _read_json(self, requirement: str, files: list[NavFile], name: str) -> None:
        """Parse the JSON parts of containers and judge them by a schema."""
        for file in files:
            try:
                file.parse()
            except strictjson.JsonError as error:
                finding = Finding(f"{file.name} JSON part", str(error), "JSON")
                self.schema_errors[requirement].append(finding)
            else:
                self._validate(file.json, name, f"{file.name}#")

    def prove(self) -> None:
        """Let the certificates decide whether the sets are conservative, where rays found nothing against
        them."""
        judged = self.done["pvs/conservative"]
        searched = judged.verdict == "not refuted"
        if not searched and judged.note != NO_RAYS:
            return
        if any(self.done[identifier].verdict != "pass" for identifier in certificates.IDS):
            return
        if len(self.subject.certificate_files) < len(self.subject.sectors):
            return
        judged.verdict = "proved"
        proof = self.subject.proof
        said = f"{proof['certificates']} certificates with {proof['leaves']} leaves"
        judged.note = f"{said}; {judged.note}"


_GOOD = ("pass", "not refuted", "proved")

_MEMBERS = {
    "core/version": "version",
    "core/grid-exponent": "grid",
    "core/sectors-listed": "sectors",
    "lod/parameters": "lod",
    "provenance/stated": "provenance",
}
"""Requirements on one member of the entry object; that it is there is the subject of core/entry-object."""


def _is_packet(identifier: str) -> bool:
    """Whether a requirement is about packets."""
    return REGISTRY[identifier].conformance_class == PACKET


def _collect(requirement: Requirement, findings: Findings) -> Judgement:
    """Run a check to its end."""
    result = Judgement(requirement, "pass")
    while True:
        try:
            finding = next(findings)
        except StopIteration as end:
            outcome = end.value
            break
        result.count += 1
        if result.count <= MAX_FINDINGS:
            result.findings.append(finding)
    if result.count:
        result.verdict = "fail"
    elif isinstance(outcome, NotRun):
        result.verdict, result.note = "not run", outcome.reason
    if isinstance(outcome, NotRefuted):
        result.note = outcome.basis
        result.verdict = "fail" if result.count else "not refuted"
    return result

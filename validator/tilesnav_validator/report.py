"""The report, for people and for programs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tilesnav_validator import __version__
from tilesnav_validator.findings import Finding
from tilesnav_validator.registry import SPEC_VERSION
from tilesnav_validator.runner import Judgement, Result
from tilesnav_validator.subject import TOLERANCE_IN_STEPS

CONFIDENCE = 0.95


def as_json(result: Result, path: Path) -> dict[str, Any]:
    """Return the report as ``report.schema.json`` describes it."""
    settings = result.subject.settings
    return {
        "tool": "tilesnav-validate",
        "toolVersion": __version__,
        "specVersion": SPEC_VERSION,
        "input": str(path),
        "verdict": result.verdict,
        "notExamined": result.not_examined,
        "seed": settings.seed,
        "rays": settings.rays,
        "tolerances": _tolerances(result),
        "requirements": [_requirement(judgement) for judgement in result.judgements],
        "seconds": {stage: round(seconds, 4) for stage, seconds in result.seconds.items()},
    } | _found(result)


def _found(result: Result) -> dict[str, Any]:
    """What the search and the certificates brought, as far as there were any."""
    subject = result.subject
    found = {
        "search": subject.search,
        "certificates": subject.proof if "files" in subject.proof else {},
        "packets": _packets(result),
    }
    return {name: value for name, value in found.items() if value}


def _packets(result: Result) -> dict[str, Any]:
    """Numbers of the packets that were handed in, and of the states that they lead through."""
    sequences, followed = result.subject.sequences, result.subject.followed
    if not sequences:
        return {}
    return {
        "files": len(sequences),
        "packets": sum(len(sequence.packets) for sequence in sequences),
        "keyFrames": sum(packet.is_key for sequence in sequences for packet in sequence.packets),
        "bytes": sum(sequence.size for sequence in sequences),
        "states": followed.states if followed else 0,
        "stateBytes": followed.bytes if followed else 0,
        "seconds": round(followed.seconds, 4) if followed else 0.0,
    }


def _tolerances(result: Result) -> dict[str, float]:
    tolerances = {"geometryInSteps": TOLERANCE_IN_STEPS}
    passed = {j.requirement.id for j in result.judgements if j.verdict == "pass"}
    if {"core/entry-object", "core/grid-exponent"} <= passed:
        tolerances |= {"step": result.subject.step, "geometry": result.subject.tolerance}
    return tolerances


def _requirement(judgement: Judgement) -> dict[str, Any]:
    row: dict[str, Any] = {
        "id": judgement.requirement.id,
        "verdict": judgement.verdict,
        "severity": judgement.requirement.severity,
        "findingCount": judgement.count,
        "findings": [_finding(finding) for finding in judgement.findings],
    }
    return row | ({"note": judgement.note} if judgement.note else {})


def _finding(finding: Finding) -> dict[str, Any]:
    row: dict[str, Any] = {"where": finding.where, "measured": finding.measured, "allowed": finding.allowed}
    return row | ({"witness": finding.witness} if finding.witness else {})


def as_text(result: Result, path: Path) -> Iterator[str]:
    """Yield the lines of the report for people."""
    for judgement in result.judgements:
        note = f" ({judgement.note})" if judgement.note else ""
        yield f"{judgement.verdict:12} {judgement.requirement.id}{note}"
        for finding in judgement.findings:
            yield f"             {finding.where}: {finding.measured}; allowed: {finding.allowed}"
            if finding.witness:
                yield "             witness: " + ", ".join(
                    f"{name} {value}" for name, value in finding.witness.items()
                )
        if judgement.count > len(judgement.findings):
            yield f"             and {judgement.count - len(judgement.findings)} more"
    if result.subject.search:
        yield result.subject.search["statement"]
    if "files" in result.subject.proof:
        yield _proof(result.subject.proof)
    if result.subject.sequences:
        yield _followed(_packets(result))
    seconds = ", ".join(f"{stage} {value:.2f} s" for stage, value in result.seconds.items())
    yield f"time: {seconds}"
    counts = dict.fromkeys(("pass", "proved", "not refuted", "not run", "fail"), 0)
    for judgement in result.judgements:
        counts[judgement.verdict] += 1
    summary = ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count)
    yield f"{path}: {_verdict(result)} ({summary})"


def _proof(proof: dict[str, Any]) -> str:
    numbers = (f"{proof[name]} {name}" for name in ("files", "certificates", "leaves", "bytes"))
    return f"certificates: {', '.join(numbers)}, checked in {proof['seconds']:.2f} s"


def _followed(found: dict[str, Any]) -> str:
    numbers = (f"{found[name]} {name}" for name in ("files", "packets", "bytes"))
    states = f"{found['states']} states of {found['stateBytes']} bytes in {found['seconds']:.2f} s"
    return f"packets: {', '.join(numbers)}, {found['keyFrames']} key frames; followed through {states}"


def _verdict(result: Result) -> str:
    if result.verdict != "incomplete":
        return result.verdict
    return f"incomplete: nothing failed, but not examined: {', '.join(result.not_examined)}"

"""What the validator reports fits report.schema.json, and its exit status is that of case.json."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from suite import Case, cases, judged, registry, schemas, validator, verdict

from tilesnav_validator import report
from tilesnav_validator.cli import main

SAMPLES = [
    *(next(c for c in cases() if c.status == status) for status in (0, 1, 2)),
    *(next(c for c in cases() if c.status == status and "packets" in c.facts) for status in (0, 1)),
]


def test_reports_fit_their_schema() -> None:
    judge = validator(schemas(), "report.schema.json")
    for case in cases():
        result = verdict(case)
        if result is not None:
            text = json.dumps(report.as_json(result, case.folder / case.facts["tileset"]), allow_nan=False)
            assert [error.json_path for error in judge.iter_errors(json.loads(text))] == [], case.name


def test_reports_name_every_requirement_once() -> None:
    without_packets, with_packets = SAMPLES[1], SAMPLES[4]
    for case in (without_packets, with_packets):
        result = verdict(case)
        assert result is not None
        rows = report.as_json(result, Path("tileset.json"))["requirements"]
        assert [row["id"] for row in rows] == judged(case)
    assert judged(with_packets) == list(registry())


@pytest.mark.parametrize("case", SAMPLES, ids=lambda case: case.name)
def test_exit_status_is_that_of_the_case(case: Case, capsys: pytest.CaptureFixture[str]) -> None:
    tileset = str(case.folder / case.facts["tileset"])
    packets = [
        word for name in case.facts.get("packets", []) for word in ("--packets", str(case.folder / name))
    ]
    assert main([tileset, "--json", "--rays", "1000", *packets]) == case.status
    printed = capsys.readouterr()
    if case.status == 2:
        assert tileset in printed.err
    else:
        assert json.loads(printed.out)["verdict"] == ("valid" if case.status == 0 else "invalid")

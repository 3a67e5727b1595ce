"""The validator says about every conformance case what case.json says."""

from __future__ import annotations

import pytest
from suite import Case, cases, failed_requirements, judged, registry, schemas, verdict

VALID = [case for case in cases() if case.status == 0]
INVALID = [case for case in cases() if case.status == 1]
UNREADABLE = [case for case in cases() if case.status == 2]
WITHOUT_PORTALS = {"valid/one-cell"}


def name_of(case: Case) -> str:
    return case.name


def test_there_are_cases_of_every_kind() -> None:
    assert len(VALID) > 20
    assert len(INVALID) > 100
    assert len(UNREADABLE) >= 4


@pytest.mark.parametrize("case", cases(), ids=name_of)
def test_case_json_fits_its_schema(case: Case) -> None:
    assert failed_requirements(schemas(), "case.schema.json", case.facts) == set()


@pytest.mark.parametrize("case", VALID, ids=name_of)
def test_a_valid_case_passes_every_check(case: Case) -> None:
    result = verdict(case)
    assert result is not None
    wrong = {
        j.requirement.id: (j.verdict, j.note, j.findings) for j in result.judgements if j.verdict == "fail"
    }
    assert wrong == {}
    assert result.valid


@pytest.mark.parametrize("case", VALID, ids=name_of)
def test_no_check_is_left_out_of_a_valid_case(case: Case) -> None:
    result = verdict(case)
    assert result is not None
    left_out = {j.requirement.id: j.note for j in result.judgements if j.verdict == "not run"}
    assert left_out == {}
    assert [j.requirement.id for j in result.judgements] == judged(case)


def test_only_sampling_ends_with_not_refuted() -> None:
    for case in VALID:
        result = verdict(case)
        assert result is not None
        searched = {j.requirement.id for j in result.judgements if j.verdict in {"not refuted", "proved"}}
        sampling = {name for name, row in registry().items() if row["checked_by"] == "sampling"}
        assert searched == sampling - (set() if result.subject.coarse else {"level/error-holds"})


def test_what_every_sector_has_certificates_for_is_proved() -> None:
    proved = set()
    for case in VALID:
        result = verdict(case)
        assert result is not None
        with_certificates = len(result.subject.certificate_files)
        found = {j.requirement.id: j.verdict for j in result.judgements}["pvs/conservative"]
        assert (found == "proved") == (with_certificates == len(result.subject.sectors)), case.name
        proved |= {case.name} if found == "proved" else set()
    assert {"valid/one-cell-proved", "valid/fused-proofs", "valid/nothing-to-prove"} <= proved


@pytest.mark.parametrize("case", INVALID, ids=name_of)
def test_an_invalid_case_fails_its_requirement_and_no_other(case: Case) -> None:
    result = verdict(case)
    assert result is not None, "could not be read"
    failed = {j.requirement.id: j.findings for j in result.judgements if j.verdict == "fail"}
    assert failed.keys() == {case.facts["requirement"]}, failed
    assert not result.valid


@pytest.mark.parametrize("case", UNREADABLE, ids=name_of)
def test_an_unreadable_case_is_not_judged(case: Case) -> None:
    assert verdict(case) is None

"""The command: exit status, both reports, order of the checks, ids of schema errors."""

from __future__ import annotations

import json
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from validator_fixture import Small

from tilesnav_validator import checks, cli, registry, runner, schemarules

JUDGED = [row.id for row in registry.REGISTRY.values() if row.conformance_class != "packet"]
"""What a tileset is judged by."""
PASSES = len(JUDGED) - 1
"""All but the one requirement that a search cannot settle."""


def test_valid_and_invalid(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = Small().write(tmp_path)
    assert cli.main([str(path), "--rays", "1e3", "--seed", "7", "--threads", "0"]) == 0
    text = capsys.readouterr().out
    assert "not refuted  pvs/conservative (1000 rays, seed 7)" in text
    assert text.splitlines()[-1].endswith(f"valid ({PASSES} pass, 1 not refuted)")
    small = Small()
    small.groups["cells"]["kinds"] = [3, 4]
    assert cli.main([str(small.write(tmp_path)), "--rays", "1e3"]) == 1
    text = capsys.readouterr().out
    assert "fail         cell/known-kind\n             cell 0: kind 3; allowed: 0 or 1" in text
    assert f"invalid ({PASSES - 1} pass, 1 not refuted, 1 fail)" in text


def fits(text: str) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(text)
    jsonschema.Draft202012Validator(registry.schema("report.schema.json")).validate(report)
    return report


def test_json_reports_fit_their_schema(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    small = Small()
    assert cli.main([str(small.write(tmp_path)), "--json", "--rays", "500"]) == 0
    report = fits(capsys.readouterr().out)
    assert (report["verdict"], report["rays"], report["search"]["uniformRays"]) == ("valid", 500, 250)
    assert report["notExamined"] == []
    assert [row["id"] for row in report["requirements"]] == JUDGED
    small.groups["pvs"]["faces"] = [0, 1, 2, 3, 4, 0, 1, 2, 4]
    assert cli.main([str(small.write(tmp_path)), "--json"]) == 1
    report = fits(capsys.readouterr().out)
    row = next(row for row in report["requirements"] if row["id"] == "pvs/conservative")
    assert row["findings"][0]["witness"]["face"] == 3
    assert "lod/fine-enough" in report["notExamined"]
    small.extension["grid"]["exponent"] = 1
    assert cli.main([str(small.write(tmp_path)), "--json"]) == 1
    assert set(fits(capsys.readouterr().out)["tolerances"]) == {"geometryInSteps"}


def test_without_rays_the_verdict_is_incomplete(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(Small().write(tmp_path))
    assert cli.main([path, "--rays", "0"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    said = f"incomplete: nothing failed, but not examined: pvs/conservative ({PASSES} pass, 1 not run)"
    assert last.endswith(f": {said}")
    assert cli.main([path, "--rays", "0", "--json"]) == 0
    report = fits(capsys.readouterr().out)
    assert (report["verdict"], report["notExamined"]) == ("incomplete", ["pvs/conservative"])
    small = Small()
    small.groups["cells"]["kinds"] = [3, 4]
    assert cli.main([str(small.write(tmp_path)), "--rays", "0", "--json"]) == 1
    assert fits(capsys.readouterr().out)["verdict"] == "invalid"


def test_numbers_of_rays_may_be_written_with_an_exponent() -> None:
    assert cli._parser().parse_args(["x", "--rays", "1e7"]).rays == 10**7


@pytest.mark.parametrize(
    ("member", "absent"),
    [
        ("", set(runner._MEMBERS)),
        ("version", {"core/version"}),
        ("lod", {"lod/parameters"}),
    ],
)
def test_requirements_on_what_is_not_there_are_not_run(tmp_path: Path, member: str, absent: set[str]) -> None:
    small = Small()
    if member:
        del small.extension[member]
    else:
        del small.tileset["extensions"]
    result = runner.judge(small.write(tmp_path), cli.Settings(rays=0))
    verdicts = {j.requirement.id: j.verdict for j in result.judgements if j.requirement.stage == "schema"}
    assert [name for name, verdict in verdicts.items() if verdict == "fail"] == ["core/entry-object"]
    assert {name for name, verdict in verdicts.items() if verdict == "not run"} == absent


def test_findings_beyond_the_cap_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    small = Small()
    small.groups["pvs"]["faces"] = [9] * 9
    small.groups["pvs"]["faces"] = [9] * 30
    small.groups["pvs"]["offsets"] = [0, 15, 30]
    assert cli.main([str(small.write(tmp_path)), "--json"]) == 1
    rows = {row["id"]: row for row in fits(capsys.readouterr().out)["requirements"]}
    assert (rows["pvs/sorted-faces"]["findingCount"], len(rows["pvs/sorted-faces"]["findings"])) == (30, 20)
    assert rows["pvs/conservative"]["note"] == "pvs/sorted-faces: fail"
    assert cli.main([str(tmp_path / "tileset.json")]) == 1
    assert "and 10 more" in capsys.readouterr().out


def test_unreadable_input_and_wrong_usage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([str(tmp_path / "missing.json")]) == 2
    assert cli.main([str(tmp_path)]) == 2
    assert "missing.json: no such file" in capsys.readouterr().err
    for arguments in ([], ["x", "--rays", "-1"], ["x", "--rays", "many"], ["x", "--seed", "0.5"], ["--what"]):
        with pytest.raises(SystemExit) as end:
            cli.main(arguments)
        assert end.value.code == 2


def test_an_internal_error_has_its_own_status(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise KeyError("x")

    monkeypatch.setattr(runner, "judge", broken)
    assert cli.main([str(Small().write(tmp_path))]) == 3


def test_list_and_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--list"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(registry.REGISTRY)
    with pytest.raises(SystemExit) as end:
        cli.main(["--version"])
    assert end.value.code == 0
    assert "3DTILES_nav 0.1.0" in capsys.readouterr().out


def test_as_a_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = Small().write(tmp_path)
    command = [sys.executable, "-m", "tilesnav_validator", str(path), "--rays", "10"]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    monkeypatch.setattr(sys, "argv", ["tilesnav-validate", "--list"])
    with pytest.raises(SystemExit) as end:
        runpy.run_module("tilesnav_validator", run_name="__main__")
    assert end.value.code == 0
    command = [sys.executable, "-m", "tilesnav_validator.cli", "absent.json"]
    assert subprocess.run(command, capture_output=True, check=False).returncode == cli.UNREADABLE
    assert "main" in runpy.run_module("tilesnav_validator.__main__", run_name="imported")
    assert done.stderr == ""


def test_a_closed_pipe_keeps_the_verdict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def closed(*_: object) -> None:
        raise BrokenPipeError

    small = Small()
    small.groups["cells"]["kinds"] = [3, 4]
    path = small.write(tmp_path)
    with (tmp_path / "out").open("w") as stream:
        monkeypatch.setattr(sys, "stdout", stream)
        monkeypatch.setattr("builtins.print", closed)
        assert cli.main([str(path), "--rays", "10"]) == 1


def test_a_closed_pipe_is_no_error(tmp_path: Path) -> None:
    path = Small().write(tmp_path)
    command = f"{sys.executable} -m tilesnav_validator {path} --rays 10 | head -c 1"
    done = subprocess.run(["bash", "-c", command], check=False, capture_output=True, text=True)
    assert done.stderr == ""


def test_every_requirement_is_judged_after_what_it_rests_on() -> None:
    order = runner.order()
    assert sorted(order) == sorted(registry.REGISTRY)
    for identifier, registered in checks.registered().items():
        assert all(order.index(need) < order.index(identifier) for need in registered.needs)
    stages = [registry.STAGES.index(registry.REGISTRY[identifier].stage) for identifier in order]
    assert stages == sorted(stages)


def test_a_requirement_has_one_check() -> None:
    with pytest.raises(ValueError, match="two checks of pvs/digest"):
        checks.check("pvs/digest")(lambda _: iter(()))


def test_registered_checks_and_schemas_share_out_the_requirements() -> None:
    by_code = {row.id for row in registry.REGISTRY.values() if row.checked_by != "schema"}
    assert checks.registered_ids() == by_code


def test_data_come_from_the_package_where_it_has_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside_repository = registry._locate("nav.schema.json")
    assert inside_repository.is_file()
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "nav.schema.json").write_text("{}")
    monkeypatch.setattr(registry, "_PACKAGE", tmp_path)
    assert registry._locate("nav.schema.json") == tmp_path / "data" / "nav.schema.json"


def test_a_schema_error_without_a_way_to_it_is_not_passed_over() -> None:
    error = jsonschema.ValidationError("strange", schema_path=["properties", "x"], schema={"other": 1})
    with pytest.raises(LookupError, match="strange"):
        schemarules.requirement_of(error, "nav.schema.json")


def test_witnesses_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    small = Small()
    small.groups["pvs"]["faces"] = [0, 1, 2, 3, 4, 0, 1, 2, 4]
    assert cli.main([str(small.write(tmp_path))]) == 1
    assert "witness: cell 1, face 3, c [" in capsys.readouterr().out


def test_severity_comes_from_the_registry() -> None:
    assert registry.Requirement("a/b", "a", "shall", "io", "check", "").severity == "error"
    assert registry.Requirement("a/b", "a", "should", "io", "check", "").severity == "warning"


@pytest.mark.parametrize(
    ("change", "requirement"),
    [
        (lambda t: t.pop("extensionsUsed"), "core/extension-used"),
        (lambda t: t.update(extensionsRequired=["3DTILES_nav"]), "core/extension-optional"),
        (lambda t: t["asset"].update(version="1.0"), "core/asset-version"),
        (lambda t: t.pop("extensions"), "core/entry-object"),
        (lambda t: t["extensions"]["3DTILES_nav"].update(version="0.2.0"), "core/version"),
        (lambda t: t["extensions"]["3DTILES_nav"]["grid"].update(exponent=1), "core/grid-exponent"),
        (lambda t: t["extensions"]["3DTILES_nav"].update(sectors=[]), "core/sectors-listed"),
        (lambda t: t["extensions"]["3DTILES_nav"]["lod"].update(base=1), "lod/parameters"),
        (lambda t: t["extensions"]["3DTILES_nav"]["provenance"].pop("encoder"), "provenance/stated"),
        (lambda t: t["root"]["content"]["extensions"]["3DTILES_nav"].pop("level"), "core/content-object"),
        (lambda t: t["root"]["content"]["extensions"].update({"3DTILES_nav": []}), "core/content-object"),
    ],
)
def test_ids_of_schema_errors(tmp_path: Path, change: Any, requirement: str) -> None:
    small = Small()
    path = small.write(tmp_path)
    change(small.tileset)
    path.write_text(json.dumps(small.tileset))
    result = runner.judge(path, cli.Settings(rays=0))
    assert [j.requirement.id for j in result.judgements if j.verdict == "fail"] == [requirement]
    assert all(
        j.verdict == "not run" for j in result.judgements if j.requirement.stage not in ("io", "schema")
    )


def test_long_values_are_shown_in_short() -> None:
    found = list(schemarules.errors([1] * 1000, "nav.schema.json", "x"))
    assert [(i, f.measured) for i, f in found] == [("container/json", "an array of 1000: 1, 1, 1, 1, 1")]
    found = list(schemarules.errors({"a" * 9: 1}, "content.3DTILES_nav.schema.json", "x"))
    assert all(f.measured == "an object with " + "a" * 9 for _, f in found)
    assert len(found) == 1

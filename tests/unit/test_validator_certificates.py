"""Certificate files: verdicts, reports, limits, and files that nobody vouches for."""

from __future__ import annotations

import json
import struct
from fractions import Fraction
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from certificate_fixture import Proven, pack, tables
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from validator_fixture import failed, failures

from tilesnav_validator import cli, proofs, regions, registry
from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import Result, judge


def verdicts(result: Result) -> dict[str, str]:
    return {judgement.requirement.id: judgement.verdict for judgement in result.judgements}


def test_a_proved_tileset(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(Proven().write(tmp_path))
    assert cli.main([path, "--rays", "1e3"]) == 0
    text = capsys.readouterr().out
    said = "proved       pvs/conservative (2 certificates with 3 leaves; 1000 rays, seed 0)"
    assert said in text
    assert "certificates: 1 files, 2 certificates, 3 leaves, " in text
    # no packets are given, so that class is not judged
    judged = sum(one.conformance_class != "packet" for one in registry.REGISTRY.values())
    assert text.splitlines()[-1].endswith(f": valid ({judged - 1} pass, 1 proved)")
    assert cli.main([path, "--rays", "1e3", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator(registry.schema("report.schema.json")).validate(report)
    assert report["verdict"] == "valid"
    size = (tmp_path / "0.cert").stat().st_size
    facts = report["certificates"]
    assert facts.pop("seconds") > 0
    assert facts == {"files": 1, "certificates": 2, "leaves": 3, "bytes": size}


def test_proofs_need_no_rays(tmp_path: Path) -> None:
    result = judge(Proven().write(tmp_path), Settings(rays=0))
    assert verdicts(result)["pvs/conservative"] == "proved"
    assert (result.verdict, result.not_examined) == ("valid", [])


def test_without_a_certificate_file_there_is_nothing_to_judge(tmp_path: Path) -> None:
    small = Proven()
    small.write(tmp_path)
    del small.extension["sectors"][0]["certificates"]
    path = tmp_path / "tileset.json"
    path.write_text(json.dumps(small.tileset))
    result = judge(path, Settings(rays=1000))
    found = verdicts(result)
    assert {found[name] for name in found if name.startswith("certificate/")} == {"pass"}
    assert found["pvs/conservative"] == "not refuted"
    assert result.subject.proof == {}


def test_a_witness_outweighs_proofs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small = Proven()
    small.groups["pvs"] |= {"offsets": [0, 5, 8], "faces": [0, 1, 2, 3, 4, 0, 1, 2]}
    small.members["targets"] = [3, 5, 6]
    small.members["targetOffsets"] = [0, 1, 3]
    small.members["cutOffsets"], small.members["cuts"] = [0, 1, 2], [0, 0]
    small.members["leaves"] = [0, 0]
    path = small.write(tmp_path)
    result = judge(path, Settings(rays=2000))
    assert {"certificate/sound", "pvs/conservative"} <= set(failed(result))
    monkeypatch.setattr(proofs, "faults", lambda *_: iter(()))  # a checker that believes everything
    result = judge(path, Settings(rays=2000))
    assert verdicts(result)["certificate/sound"] == "pass"
    assert verdicts(result)["pvs/conservative"] == "fail"


@pytest.mark.parametrize("name", ["sound", "complete"])
def test_work_without_end_is_not_begun(tmp_path: Path, name: str) -> None:
    pairs = {"sound": 6, "complete": 4}[name]
    path = Proven().write(tmp_path)
    result = judge(path, Settings(rays=1000, proof_pairs=pairs - 1))
    judged = {j.requirement.id: j for j in result.judgements}
    assert judged["certificate/sound"].note.endswith(f"6 pairs to look at, more than {pairs - 1}")
    assert judged[f"certificate/{name}"].verdict == "not run"
    assert judged["pvs/conservative"].verdict == "not refuted"
    assert result.verdict == "incomplete"
    assert judge(path, Settings(rays=1000, proof_pairs=6)).verdict == "valid"


@pytest.mark.parametrize(("leaves", "pairs"), [(1, 1), (2, 3), (1, 2**17), (3, 5)])
def test_batches_of_any_size_say_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, leaves: int, pairs: int
) -> None:
    small = Proven()
    small.members["occluderOffsets"], small.members["occluders"] = [0, 2, 3], [2, 3, 2]
    small.members["leaves"] = [0, 1, 0]
    monkeypatch.setattr(proofs, "LEAVES", leaves)
    monkeypatch.setattr(proofs, "PAIRS", pairs)
    result = judge(small.write(tmp_path), Settings(rays=0))
    findings = [f for j in result.judgements if j.verdict == "fail" for f in j.findings]
    assert [finding.where for finding in findings] == ["0.cert certificate 1 leaf 1"]


@pytest.mark.parametrize("wide", [0, 1])
def test_every_certificate_has_its_own_region(tmp_path: Path, wide: int) -> None:
    small = Proven()
    small.members |= {"cuts": [0, 0], "cutOffsets": [0, 1, 2], "leaves": [0, 0]}
    small.members["regions"] = [list(region) for region in small.members["regions"]]
    small.members["regions"][wide][3] = 4097  # the wall is at 4096
    result = judge(small.write(tmp_path), Settings(rays=0))
    findings = [finding for judged in result.judgements for finding in judged.findings]
    assert [f.where for f in findings] == [f"0.cert certificate {wide} leaf {wide}"]
    assert findings[0].measured == "face 2 of the occluder meets the region"


def test_a_certificate_whose_targets_are_all_flat_says_nothing(tmp_path: Path) -> None:
    small = Proven()
    small.members["targets"], small.members["targetOffsets"] = [4, 6], [0, 1, 2]
    small.members["uses"], small.members["cellOffsets"] = [], [0, 0, 0]
    assert failures(small.write(tmp_path)) == ["certificate/sound", "certificate/complete"]


def test_faces_without_area_may_be_targets_beside_others(tmp_path: Path) -> None:
    small = Proven()
    small.objects[2] = [[(6, 0, 1), (6, 0, 1.5), (6, 0, 2)]]
    small.members |= {
        "regions": [small.members["regions"][0]],
        "shapes": [0],
        "targets": [4, 5, 6],
        "targetOffsets": [0, 3],
        "cuts": [0],
        "cutOffsets": [0, 1],
        "leaves": [0],
        "uses": [0, 0],
        "cellOffsets": [0, 1, 2],
    }
    assert failures(small.write(tmp_path)) == []


def test_proofs_about_the_wrong_cells(tmp_path: Path) -> None:
    small = Proven()
    small.cert = pack(small.members).replace(b'"cellCount": 2', b'"cellCount": 1')
    assert failures(small.write(tmp_path)) == ["certificate/container"]


def test_a_cell_that_is_empty_lies_in_every_region(tmp_path: Path) -> None:
    small = Proven()
    small.groups["cells"]["planes"][0][0][3] = 4.0  # x >= 4 and x <= 0
    found = failures(small.write(tmp_path))
    assert "cell/non-empty" in found
    assert "certificate/region-holds-cell" not in found


def test_corners_of_cells_are_not_rounded(tmp_path: Path) -> None:
    subject = judge(Proven().write(tmp_path), Settings(rays=0)).subject
    found = subject.certificates[0]
    planes = subject.tables.planes[0].copy()
    corners = regions.corners(planes, found, -10)
    assert sorted({point[0] for point in corners}) == [-4096, 0]
    assert len(corners) == 8
    planes[1] = [0.6, 0.0, 0.8, -np.nextafter(2.0, 3)]  # slanted, through corners that are no float64
    corners = regions.corners(planes, found, -10)
    exact = (Fraction(float(np.nextafter(2.0, 3))) - Fraction(0.8)) / Fraction(0.6) * 1024
    assert max(point[0] for point in corners) == exact
    box, shape = np.array([[-4096, -2048, 1024, int(exact), 2048, 3072, 0, 0]]), np.zeros(1, np.int64)
    assert [index for index, _ in regions.outside(corners, box, shape)] == [0]
    box[0, 3] += 1
    assert list(regions.outside(corners, box, shape)) == []


def slanted_tables() -> dict[str, list[Any]]:
    """The tables with a prism for the second region, which is wider along y at its upper x."""
    members = tables()
    members["regions"] = [members["regions"][0], [*members["regions"][1][:6], -2112, 2048]]
    return members | {"shapes": [0, 1]}


CERTS = [pack(tables()), pack(slanted_tables())]


def test_a_tileset_with_a_region_that_slants(tmp_path: Path) -> None:
    small = Proven()
    small.members = slanted_tables()
    assert verdicts(judge(small.write(tmp_path), Settings(rays=0)))["pvs/conservative"] == "proved"


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_no_change_of_bytes_leads_to_an_error_of_the_program(tmp_path: Path, data: st.DataObject) -> None:
    small = Proven()
    cert = data.draw(st.sampled_from(CERTS))
    changed = bytearray(cert)
    start = 24 + struct.unpack_from("<Q", cert, 8)[0] if data.draw(st.booleans()) else 0
    for _ in range(data.draw(st.integers(1, 4))):
        changed[data.draw(st.integers(start, len(cert) - 1))] = data.draw(st.integers(0, 255))
    small.cert = bytes(changed[: data.draw(st.sampled_from([len(cert), len(cert), len(cert) - 8]))])
    result = judge(small.write(tmp_path), Settings(rays=0))
    own = {name: verdict for name, verdict in verdicts(result).items() if name.startswith("certificate/")}
    proved = verdicts(result)["pvs/conservative"] == "proved"
    assert proved == (set(own.values()) == {"pass"})


def _counts(members: dict[str, Any], name: str, value: int) -> bytes:
    return pack(members).replace(f'"{name}": '.encode(), f'"{name}": {value}'.encode())


@pytest.mark.parametrize(
    "name", ["count", "useCount", "targetCount", "cutCount", "leafCount", "occluderCount"]
)
def test_counts_that_claim_more_than_there_is(tmp_path: Path, name: str) -> None:
    small = Proven()
    small.cert = _counts(small.members, name, 200000000)
    assert failures(small.write(tmp_path)) == ["certificate/container"]

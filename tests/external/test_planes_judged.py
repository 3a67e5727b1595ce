"""What the Khronos validator says about contents with a table of planes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from survey_fixture import site_from_above, write_las

from tilesnav_ref.cli import main

pytestmark = pytest.mark.node


def test_contents_with_planes_give_no_error_and_no_warning(judge: Callable[..., str], tmp_path: Path) -> None:
    cloud, out = write_las(tmp_path / "site.las", site_from_above()), tmp_path / "tileset"
    few = ["--rays", "200", "--attempts", "0", "--min-cell", "8", "--max-cell", "32"]
    assert main(["encode", str(cloud), str(out), "--quiet", *few]) == 0
    files = sorted(out.rglob("*.glb"))
    reports = [json.loads(line) for line in judge("gltf_validate.mjs", *files).splitlines()]
    assert len(reports) == len(files) >= 1
    assert [(report["errors"], report["warnings"]) for report in reports] == [(0, 0)] * len(files)
    codes = {message["code"] for report in reports for message in report["messages"]}
    assert codes <= {"UNSUPPORTED_EXTENSION", "UNUSED_OBJECT"}  # it does not know the two extensions

"""How a tileset was made, as the entry object states it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tilesnav_ref import __version__
from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.scene.settings import SceneReport
from tilesnav_ref.visibility.model import PvsTable

NOT_OF_THE_RESULT = {"threads", "seconds", "source", "poses"}
"""Settings and findings that must not change the bytes of a tileset: machine, time and place of the run."""

ONLY_WHERE_GIVEN = {
    "transparent",
    "one_sided",
    "terrain",
    "max_range",
    "corridor",
    "sector_size",
    "sector",
    "survey",
}
"""Settings that are stated where they were given."""

CHUNK_BYTES = 1 << 20


def make_provenance(
    source: Path, settings: Mapping[str, Any], found: SceneReport, cells: CellComplex, pvs: PvsTable
) -> dict[str, Any]:
    """State encoder, parameters and what the stages say about their results.

    Parameters
    ----------
    source : Path
        The file, or folder of scans, that was encoded; its SHA-256 is stated, not its name.
    settings : mapping
        Settings dataclass of every stage, by the name of the stage.
    found : SceneReport
        Counts of the input.
    cells, pvs
        Results that state their own quality.

    Returns
    -------
    dict
        JSON values.
    """
    return {
        "encoder": f"tilesnav {__version__}",
        "parameters": {stage: _members(of_stage) for stage, of_stage in settings.items()},
        "coverage": cells.coverage,
        "sourceSha256": file_digest(source),
        "scene": _members(found),
        "undecided": {reason: int(pvs.undecided[reason]) for reason in sorted(pvs.undecided)},
    }


def file_digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal digits; of a folder that of the names and digests of its files."""
    digest = hashlib.sha256()
    if path.is_dir():
        for file in sorted(file for file in path.iterdir() if file.is_file()):
            digest.update(f"{file.name}\0{file_digest(file)}\n".encode())
        return digest.hexdigest()
    with path.open("rb") as stream:
        while chunk := stream.read(CHUNK_BYTES):
            digest.update(chunk)
    return digest.hexdigest()


def _members(values: Any) -> dict[str, Any]:
    return {
        name: value
        for name, value in asdict(values).items()
        if name not in NOT_OF_THE_RESULT and (value or name not in ONLY_WHERE_GIVEN)
    }

"""The registry of requirements, and where the data files of the specification are found."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

STAGES = ("io", "schema", "link", "binary", "geometry", "visibility")

_PACKAGE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Requirement:
    """One row of ``spec/requirements.toml``."""

    id: str
    conformance_class: str
    level: str
    stage: str
    checked_by: str
    text: str

    @property
    def severity(self) -> str:
        """``error`` for a SHALL, ``warning`` for a SHOULD."""
        return "error" if self.level == "shall" else "warning"


def _locate(name: str) -> Path:
    """Path of a data file: in the installed package, else in the folders of the repository."""
    packaged = _PACKAGE / "data" / name
    if packaged.is_file():
        return packaged
    folder = "spec" if name.endswith(".toml") else "schema"
    return _PACKAGE.parents[1] / folder / name


def _load() -> tuple[str, Mapping[str, Requirement]]:
    with _locate("requirements.toml").open("rb") as stream:
        table = tomllib.load(stream)
    rows = (
        Requirement(row["id"], row["class"], row["level"], row["stage"], row["checked_by"], row["text"])
        for row in table["requirement"]
    )
    return table["version"], MappingProxyType({row.id: row for row in rows})


SPEC_VERSION, REGISTRY = _load()


@cache
def schema(name: str) -> dict[str, Any]:
    """Return the schema of that file name, such as ``nav.schema.json``."""
    loaded: dict[str, Any] = json.loads(_locate(name).read_text(encoding="utf-8"))
    return loaded

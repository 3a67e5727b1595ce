"""All invalid cases: their texts from invalid.toml, their changes from the modules invalid_*."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path

from casebuilder import (
    invalid_cells,
    invalid_container,
    invalid_contents,
    invalid_core,
    invalid_deltas,
    invalid_packets,
    invalid_portals,
    invalid_proofs,
    invalid_states,
    levels,
    prism_proofs,
    senses,
)
from casebuilder.assemble import Case
from casebuilder.worlds import RING

MODULES = (
    invalid_core,
    invalid_contents,
    invalid_container,
    invalid_cells,
    invalid_portals,
    invalid_states,
    invalid_deltas,
    invalid_proofs,
    levels,
    prism_proofs,
    senses,
    invalid_packets,
)


def invalid_cases() -> Iterator[Case]:
    """Every invalid case; raises ValueError when texts and changes do not name the same cases."""
    texts = tomllib.loads(Path(__file__).with_name("invalid.toml").read_text(encoding="utf-8"))
    changes = {key: change for module in MODULES for key, change in module.CASES.items()}
    if texts.keys() != changes.keys():
        raise ValueError(f"without text or change: {sorted(texts.keys() ^ changes.keys())}")
    for key, change in changes.items():
        requirement, _, name = key.rpartition("/")
        yield Case(
            name,
            made=texts[key]["made"],
            catches=texts[key]["catches"],
            requirement=requirement,
            **{"world": RING, **change},
        )

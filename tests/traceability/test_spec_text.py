"""The text of the specification against the registry, the schemas and the cases."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

import pytest
from suite import CASES, ROOT, failed_requirements, registry, schemas

SPEC = (ROOT / "spec" / "README.md").read_text(encoding="utf-8")
PAGES = sorted((ROOT / "spec").glob("*.md"))
QUOTE = re.compile(r"^> \*\*(?P<id>[a-z]+/[a-z-]+)\*\* — (?P<text>.+)$", re.MULTILINE)
FENCE = re.compile(r"^```json(?P<verdict>[^\n]*)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
DUMP = re.compile(r"^```hexdump (?P<file>\S+)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
SCHEMA_OF = {
    "entry": "tileset.3DTILES_nav.schema.json",
    "tileset": "entry-tileset.schema.json",
    "content": "content.3DTILES_nav.schema.json",
    "nav": "nav.schema.json",
    "certificates": "certificates.schema.json",
    "facemap": "facemap.schema.json",
    "case": "case.schema.json",
}


def test_quotes_are_the_texts_of_the_registry() -> None:
    quotes = QUOTE.findall(SPEC)
    assert len(quotes) == len({name for name, _ in quotes}), "a requirement is quoted twice"
    assert dict(quotes) == {name: row["text"] for name, row in registry().items()}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_nothing_is_required_outside_requirement_lines(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if not QUOTE.match(line)]
    if page.name == "annex_a.md":  # generated from the registry
        kept = [line for line in kept if not line.startswith("> ")]
    assert [line for line in kept if re.search(r"\b(?:SHALL|SHOULD|MUST|REQUIRED)\b", line)] == []


def test_json_blocks_get_the_verdict_that_their_fence_states() -> None:
    blocks = FENCE.findall(SPEC)
    assert len(blocks) >= 5
    for fence, body in blocks:
        verdict, kind = fence.split()
        assert verdict in {"valid", "invalid"}, fence
        failed = failed_requirements(schemas(), SCHEMA_OF[kind], json.loads(body))
        assert (verdict == "valid") == (failed == set()), (body, failed)


def test_hex_dumps_are_the_bytes_of_committed_cases() -> None:
    dumps = DUMP.findall(SPEC)
    assert dumps
    for name, body in dumps:
        data = (CASES / name).read_bytes()
        lines = [line for line in body.splitlines() if line and not line.startswith("#")]
        for line in lines:
            offset, digits = re.fullmatch(r"([0-9a-f]{6})  ((?:[0-9a-f]{2} ?)+?)(?:  .*)?", line).groups()  # type: ignore[union-attr]
            expected = bytes.fromhex(digits)
            start = int(offset, 16)
            assert data[start : start + len(expected)] == expected, line


def test_the_state_of_the_worked_example_has_the_digest_of_its_case() -> None:
    stated = re.search(
        r"The state is `([0-9a-f\s]+)`,\s(\d+) bytes, and its SHA-256 begins with ([0-9a-f]+)", SPEC
    )
    assert stated
    state = bytes.fromhex(stated[1])
    digest = hashlib.sha256(state).digest()
    assert len(state) == int(stated[2])
    assert digest.hex().startswith(stated[3])
    assert digest in (CASES / "valid" / "one-cell" / "nav" / "0.nav").read_bytes()


def test_links_within_the_page_lead_somewhere() -> None:
    text = re.sub(r"```.*?```", "", SPEC, flags=re.DOTALL)
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    anchors = {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}
    assert set(re.findall(r"\]\(#([^)]+)\)", text)) - anchors == set()


def test_every_table_of_a_container_is_described() -> None:
    groups = {
        **schemas()["nav.schema.json"]["properties"],
        **schemas()["certificates.schema.json"]["properties"],
        **schemas()["facemap.schema.json"]["properties"],
    }
    tables = {
        f"{group}.{member}"
        for group in ("cells", "portals", "pvs", "lod", "deltas", "certificates", "faceMap")
        for member, value in groups[group]["properties"].items()
        if value["$ref"].endswith("bufferViewIndex")
    }
    types = "FLOAT64|UINT32|UINT8|INT32"
    described = re.findall(rf"^\| `([a-zA-Z]+\.[a-zA-Z]+)` \| (?:{types}) \|", SPEC, re.MULTILINE)
    assert set(described) == tables
    assert len(described) == len(tables)

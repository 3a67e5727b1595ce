"""Write one schema that holds all schemas of the format, or with --check compare the committed one.

Usage: python tools/bundle_schema.py [--check]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from generated import finish

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "schema" / "3DTILES_nav.bundle.json"
ENTRY = "entry-tileset.schema.json"
OTHERS = (
    "tileset.3DTILES_nav.schema.json",
    "content.3DTILES_nav.schema.json",
    "nav.schema.json",
    "certificates.schema.json",
    "facemap.schema.json",
    "rootProperty.schema.json",
)


def bundle() -> str:
    """Compound schema: the entry tileset, with every other schema under its own $id in $defs."""
    parts = {
        name: json.loads((ROOT / "schema" / name).read_text(encoding="utf-8")) for name in (ENTRY, *OTHERS)
    }
    whole = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": TARGET.name,
        "title": "3DTILES_nav, all schemas",
        "description": "Written by tools/bundle_schema.py; judges an entry tileset.",
        "$ref": ENTRY,
        "$defs": parts,
    }
    return json.dumps(whole, indent=2) + "\n"


if __name__ == "__main__":
    sys.exit(finish(TARGET, bundle(), sys.argv[1:]))

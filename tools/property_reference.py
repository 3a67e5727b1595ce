"""Write the property reference from the schemas, or with --check compare the committed one.

Usage: python tools/property_reference.py [--check]
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from generated import finish

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "spec" / "property_reference.md"
OBJECTS = (
    "entry-tileset.schema.json",
    "tileset.3DTILES_nav.schema.json",
    "content.3DTILES_nav.schema.json",
    "nav.schema.json",
    "certificates.schema.json",
    "facemap.schema.json",
)
BOUNDS = (
    ("minimum", "≥ {}"),
    ("exclusiveMinimum", "> {}"),
    ("maximum", "≤ {}"),
    ("minLength", "length ≥ {}"),
    ("minItems", "items ≥ {}"),
    ("maxItems", "items ≤ {}"),
    ("pattern", "`{}`"),
)
Row = tuple[str, str, str, str, str]


def _type(schema: dict[str, Any]) -> str:
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if schema.get("not") == {}:
        return "not allowed"
    if "$ref" in schema and "type" not in schema:
        return "object"
    if schema.get("type") == "array":
        return f"{_type(schema.get('items', {}))}[]"
    return str(schema.get("type", "any"))


def _bounds(schema: dict[str, Any]) -> str:
    if schema.get("minItems") is not None and schema.get("minItems") == schema.get("maxItems"):
        return f"{schema['minItems']} item" + ("s" if schema["minItems"] != 1 else "")
    return ", ".join(form.format(schema[key]) for key, form in BOUNDS if key in schema)


def _branches(schema: dict[str, Any]) -> Iterator[dict[str, Any]]:
    yield schema
    yield from schema.get("allOf", [])


def _rows(schema: dict[str, Any], prefix: str, definitions: dict[str, Any]) -> Iterator[Row]:
    """Rows of the members of an object, and of the objects within it."""
    required = {name for branch in _branches(schema) for name in branch.get("required", [])}
    for branch in _branches(schema):
        for name, member in branch.get("properties", {}).items():
            local = member.get("$ref", "").removeprefix("#/$defs/")
            full = {**definitions.get(local, {}), **member} if local in definitions else member
            need = "yes" if name in required else "no"
            link = full.get("$ref", "") if full.get("$ref", "").startswith("tileset.") else ""
            kind = f"[object](#{_anchor(link)})" if link else _type(full)
            text = full.get("description", "The entry object.")
            yield (
                f"`{prefix}{name}`",
                kind,
                _bounds(full),
                need,
                f"{text} ({full.get('$comment', 'core/entry-object')})",
            )
            if "properties" in full:
                yield from _rows(full, f"{prefix}{name}.", definitions)
            if "properties" in full.get("items", {}):
                yield from _rows(full["items"], f"{prefix}{name}[].", definitions)


def _title(name: str) -> str:
    return str(json.loads((ROOT / "schema" / name).read_text(encoding="utf-8"))["title"])


def _anchor(name: str) -> str:
    return _title(name).lower().replace(" ", "-")


def reference() -> str:
    """The page."""
    lines = [
        "# Property reference",
        "",
        "Written by `tools/property_reference.py` from the JSON Schemas.",
        "",
    ]
    lines += ["The id in parentheses is the requirement that a wrong value breaks. Every object may carry"]
    lines += [
        "`extensions` and `extras` as in 3D Tiles, and members of later versions, which a reader ignores.",
        "",
    ]
    for name in OBJECTS:
        schema = json.loads((ROOT / "schema" / name).read_text(encoding="utf-8"))
        lines += [
            f"## {schema['title']}",
            "",
            f"{schema['description']} Schema: [`{name}`](../schema/{name})",
            "",
        ]
        lines += ["| member | type | limits | needed | meaning (requirement) |", "|---|---|---|---|---|"]
        lines += [f"| {' | '.join(row)} |" for row in _rows(schema, "", schema.get("$defs", {}))]
        lines.append("")
    return "\n".join(lines).rstrip("\n") + "\n"


if __name__ == "__main__":
    sys.exit(finish(TARGET, reference(), sys.argv[1:]))

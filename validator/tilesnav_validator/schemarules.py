"""Requirements that JSON Schemas check: the id of an error is the ``$comment`` nearest above the failing
keyword."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

from tilesnav_validator.findings import Finding
from tilesnav_validator.registry import REGISTRY, schema

if TYPE_CHECKING:
    from jsonschema import Draft202012Validator
    from jsonschema.exceptions import ValidationError


@cache
def _validator(name: str) -> Draft202012Validator:
    """Validator of a schema file whose references name other schema files."""
    from jsonschema import Draft202012Validator  # noqa: PLC0415 - a tenth of a second that --list and --version save
    from referencing import Registry, Resource  # noqa: PLC0415
    from referencing.jsonschema import DRAFT202012  # noqa: PLC0415

    def retrieve(uri: str) -> Resource[Any]:
        return Resource.from_contents(schema(uri), default_specification=DRAFT202012)

    registry: Registry[Any] = Registry(retrieve=retrieve)  # type: ignore[call-arg]  # attrs alias
    return Draft202012Validator(schema(name), registry=registry)


def _follow(reference: str, name: str) -> tuple[Any, str]:
    """The schema that ``$ref`` means in the file ``name``, and the file it is in."""
    file, _, pointer = reference.partition("#")
    name = file or name
    target: Any = schema(name)
    for part in pointer.split("/")[1:]:
        target = target[part]
    return target, name


def requirement_of(error: ValidationError, name: str) -> str:
    """Return the id in the ``$comment`` nearest above the failing keyword.

    Parameters
    ----------
    error : ValidationError
    name : str
        File name of the schema that was validated against.
    """
    pending: list[tuple[Any, str, str, list[Any]]] = [
        (schema(name), name, "", list(error.absolute_schema_path))
    ]
    while pending:
        node, file, nearest, path = pending.pop()
        if isinstance(node, dict) and node.get("$comment") in REGISTRY:
            nearest = node["$comment"]
        if len(path) == 1 and node == error.schema:
            return nearest
        if isinstance(node, dict) and "$ref" in node:  # paths leave out "$ref"; what follows may be behind it
            pending.append((*_follow(node["$ref"], file), nearest, path))
        if (isinstance(node, dict) and path[0] in node) or isinstance(node, list):
            pending.append((node[path[0]], file, nearest, path[1:]))
    raise LookupError(f"no way to the keyword of {error.message[:200]}")


def errors(document: Any, name: str, where: str) -> Iterator[tuple[str, Finding]]:
    """Yield the schema errors of a document with the requirement that each breaks.

    Parameters
    ----------
    document : object
        Parsed JSON.
    name : str
        File name of the schema.
    where : str
        File, and the JSON pointer of the document in it.
    """
    seen = set()
    for error in _validator(name).iter_errors(document):
        pointer = "".join(f"/{part}" for part in error.absolute_path)
        keyword = error.schema_path[-1]
        allowed = f"{keyword} {str(error.validator_value)[:200]}"
        finding = Finding(f"{where}{pointer}", _shown(error.instance), allowed)
        row = (requirement_of(error, name), finding)
        if (row[0], finding.where, allowed) not in seen:
            seen.add((row[0], finding.where, allowed))
            yield row


def _shown(value: Any) -> str:
    """A short form of a JSON value; objects and arrays by their members."""
    if isinstance(value, dict):
        return "an object with " + (", ".join(map(str, list(value)[:20])) or "no member")
    if isinstance(value, list):
        return f"an array of {len(value)}: " + ", ".join(str(item)[:40] for item in value[:5])
    return f"{type(value).__name__} {str(value)[:100]!r}"

"""Cases whose entry tileset cannot be read at all; a validator ends with exit status 2 and judges nothing."""

from __future__ import annotations

from collections.abc import Iterator

from casebuilder.assemble import Case, Files
from casebuilder.worlds import SINGLE


def unreadable_cases() -> Iterator[Case]:
    """All cases of this module."""
    say = "A judge that says invalid where it could not read, or ends with a trace of its own code."
    for name, data, made in (
        ("empty-file", b"", "The entry tileset is an empty file."),
        ("text-renamed", b"This is no tileset.\n", "The entry tileset is a text file with the ending .json."),
        ("truncated", None, "The entry tileset ends in the middle."),
        ("not-utf-8", b'{"asset":{"version":"1.1\xff"}}', "The entry tileset has a byte that is no UTF-8."),
        ("nested-too-deep", b"[" * 100000 + b"]" * 100000, "The entry tileset nests 100,000 arrays."),
    ):

        def edit(files: Files, data: bytes | None = data) -> None:
            whole = files["tileset.json"]
            files.clear()
            files["tileset.json"] = whole[: len(whole) // 2] if data is None else data

        yield Case(name, SINGLE, made, say, exit_status=2, files=edit)

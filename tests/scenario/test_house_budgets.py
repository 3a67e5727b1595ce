"""The size of files and functions, and words that do not belong into the repository."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CODE_FOLDERS = ("src", "validator", "conformance", "tools", "benchmarks")
FILE_LINES = 400
FUNCTION_LINES = 60
FUNCTION_LINES_P90 = 30
PARAMETERS = 6
VAGUE_NAMES = {"utils", "util", "helpers", "helper", "common", "manager", "misc"}
UNFINISHED = re.compile(r"\b(?:TODO|FIXME|XXX|NotImplementedError)\b")
MACHINE_PATH = re.compile(r"(?<![\w.~$}])/(?:work|root|home)/\w|(?<![\w.~$}])/tmp/[a-z]")
TEXT_SUFFIXES = {".py", ".md", ".toml", ".json", ".mjs", ".yml", ".svg", ""}
BUILT = {"build", "dist", "site", "out", "node_modules", "__pycache__"}

Function = ast.FunctionDef | ast.AsyncFunctionDef


def tracked(folders: tuple[str, ...], suffixes: set[str]) -> list[Path]:
    """Files of the repository that are neither built nor hidden."""
    found = []
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            parts = path.relative_to(ROOT).parts
            hidden = any(part.startswith(".") or part.endswith(".egg-info") for part in parts)
            if path.is_file() and path.suffix in suffixes and not hidden and not BUILT.intersection(parts):
                found.append(path)
    return found


CODE = tracked(CODE_FOLDERS, {".py"})


def functions(path: Path) -> Iterator[Function]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, Function):
            yield node


def code_lines(function: Function, text: list[str]) -> int:
    """Lines of a function without its docstring, blank lines and lines that are only a comment."""
    body = function.body
    documented = ast.get_docstring(function, clean=False) is not None
    docstring = range(body[0].lineno, (body[0].end_lineno or 0) + 1) if documented else range(0)
    lines = range(function.lineno, (function.end_lineno or function.lineno) + 1)
    kept = [text[line - 1].strip() for line in lines if line not in docstring]
    return sum(1 for line in kept if line and not line.startswith("#"))


def lengths() -> list[tuple[int, str]]:
    found = []
    for path in CODE:
        text = path.read_text(encoding="utf-8").splitlines()
        where = path.relative_to(ROOT).as_posix()
        found += [(code_lines(one, text), f"{where}:{one.lineno} {one.name}") for one in functions(path)]
    return found


def test_files_are_short() -> None:
    sizes = {
        path.relative_to(ROOT).as_posix(): len(path.read_text(encoding="utf-8").splitlines()) for path in CODE
    }
    assert len(sizes) > 50, "the walk over the code has lost its folders"
    assert {where: size for where, size in sizes.items() if size > FILE_LINES} == {}


def test_no_function_is_long() -> None:
    assert [(size, where) for size, where in lengths() if size > FUNCTION_LINES] == []


def test_nine_of_ten_functions_are_small() -> None:
    sizes = sorted(size for size, _ in lengths())
    assert sizes[len(sizes) * 9 // 10] <= FUNCTION_LINES_P90


def test_functions_take_few_parameters() -> None:
    crowded = []
    for path in CODE:
        for one in functions(path):
            arguments = one.args
            names = [a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
            count = len([name for name in names if name not in ("self", "cls")])
            if count > PARAMETERS:
                crowded.append((path.relative_to(ROOT).as_posix(), one.name, count))
    assert crowded == []


def test_modules_say_what_they_hold() -> None:
    assert [path.as_posix() for path in CODE if path.stem in VAGUE_NAMES] == []


def test_nothing_is_left_unfinished() -> None:
    found = []
    for path in CODE:
        text = path.read_text(encoding="utf-8")
        found += [(path.relative_to(ROOT).as_posix(), match[0]) for match in UNFINISHED.finditer(text)]
    assert found == []


def test_no_path_of_one_machine() -> None:
    folders = (*CODE_FOLDERS, "docs", "spec", "schema", "tests")
    files = [
        *tracked(folders, TEXT_SUFFIXES),
        *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "Makefile")),
    ]
    found = [
        (path.relative_to(ROOT).as_posix(), match[0])
        for path in files
        for match in MACHINE_PATH.finditer(path.read_text(encoding="utf-8", errors="replace"))
    ]
    assert found == []

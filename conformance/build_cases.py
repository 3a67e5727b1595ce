"""Write the conformance cases, or with --check say whether the committed ones are what would be written.

Usage: python conformance/build_cases.py [--check]
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from casebuilder import levels, senses, valid_packets
from casebuilder.assemble import Case, assemble
from casebuilder.invalid import invalid_cases
from casebuilder.schema_cases import schema_files
from casebuilder.unreadable import unreadable_cases
from casebuilder.valid import valid_cases

HERE = Path(__file__).resolve().parent
FOLDERS = ("cases", "schema")


def all_cases() -> list[Case]:
    """Every case, valid ones first."""
    groups = (
        valid_cases,
        senses.valid_cases,
        levels.level_cases,
        valid_packets.valid_cases,
        invalid_cases,
        unreadable_cases,
    )
    return [case for group in groups for case in group()]


def build() -> dict[str, bytes]:
    """All files by their path below this folder."""
    files = {}
    for case in all_cases():
        for name, data in assemble(case).items():
            path = f"cases/{case.folder}/{name}"
            if path in files:
                raise ValueError(f"two cases write {path}")
            files[path] = data
    return files | {f"schema/{name}": data for name, data in schema_files().items()}


def differences(files: dict[str, bytes]) -> list[str]:
    """What is missing, stale or left over in this folder."""
    committed = {
        str(p.relative_to(HERE)): p for folder in FOLDERS for p in (HERE / folder).rglob("*") if p.is_file()
    }
    found = [f"missing: {path}" for path in files.keys() - committed.keys()]
    found += [f"left over: {path}" for path in committed.keys() - files.keys()]
    both = files.keys() & committed.keys()
    return sorted(
        found + [f"differs: {path}" for path in both if committed[path].read_bytes() != files[path]]
    )


def write(files: dict[str, bytes]) -> None:
    """Replace the folders of the cases."""
    for folder in FOLDERS:
        shutil.rmtree(HERE / folder, ignore_errors=True)
    for path, data in files.items():
        target = HERE / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)


def main() -> int:
    """Run the command; 0 when all is up to date."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare only, write nothing")
    files = build()
    if parser.parse_args().check:
        found = differences(files)
        sys.stderr.writelines(f"{line}\n" for line in found)
        return 1 if found else 0
    write(files)
    return 0


if __name__ == "__main__":
    sys.exit(main())

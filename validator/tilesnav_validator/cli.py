"""Command line: arguments, printing and exit status only."""

from __future__ import annotations

import argparse
import json
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tilesnav_validator import __version__
from tilesnav_validator.findings import Settings, UnreadableInputError
from tilesnav_validator.registry import REGISTRY, SPEC_VERSION

if TYPE_CHECKING:
    from tilesnav_validator.runner import Result

VALID, INVALID, UNREADABLE, INTERNAL = 0, 1, 2, 3

_log = logging.getLogger(__name__)


def _count(text: str) -> int:
    """A whole number of 0 or more; ``1e6`` is one too."""
    value = float(text)
    if not value.is_integer() or not 0 <= value <= 1e12:
        raise ValueError(text)
    return int(value)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tilesnav-validate",
        description="Judge a tileset against every requirement of the extension 3DTILES_nav.",
        epilog="Exit status: 0 nothing failed, 1 invalid, 2 unreadable or wrong usage, 3 internal error.",
    )
    default = Settings()
    parser.add_argument("tileset", nargs="?", type=Path, help="the entry tileset, a JSON file")
    parser.add_argument("--json", action="store_true", help="print a report that fits report.schema.json")
    parser.add_argument(
        "--rays",
        type=_count,
        default=default.rays,
        metavar="N",
        help="rays that search for missing faces (default 1e6); 0 leaves pvs/conservative unexamined",
    )
    parser.add_argument(
        "--seed", type=_count, default=default.seed, metavar="S", help="seed of everything random (default 0)"
    )
    parser.add_argument(
        "--threads",
        type=_count,
        default=os.cpu_count() or 1,
        metavar="T",
        help="threads that cast rays (default: all)",
    )
    parser.add_argument(
        "--packets",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="judge a sequence of packets for the tileset, too; may be given more than once",
    )
    parser.add_argument("--list", action="store_true", help="print the requirements and end")
    version = f"tilesnav-validate {__version__}, 3DTILES_nav {SPEC_VERSION}"
    parser.add_argument("--version", action="version", version=version)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.list:
        for row in REGISTRY.values():
            print(f"{row.id:30} {row.level:7} {row.stage:11} {row.checked_by}")
        return VALID
    if options.tileset is None:
        parser.error("the entry tileset is missing")
    settings = Settings(
        rays=options.rays,
        seed=options.seed,
        threads=max(1, options.threads),
        packets=tuple(options.packets),
    )
    return _judge(options.tileset, settings, options.json)


def _judge(path: Path, settings: Settings, wants_json: bool) -> int:
    from tilesnav_validator import runner  # noqa: PLC0415 - numpy is not needed for --list and --version

    try:
        result = runner.judge(path, settings)
        _print(result, path, wants_json)
    except UnreadableInputError as error:
        print(f"tilesnav-validate: {error}", file=sys.stderr)
        return UNREADABLE
    except Exception:  # noqa: BLE001 - the last line of defence turns a bug into exit status 3, with its traceback
        _log.exception("internal error; please report it")
        return INTERNAL
    return VALID if result.valid else INVALID


def _print(result: Result, path: Path, wants_json: bool) -> None:
    from tilesnav_validator import report  # noqa: PLC0415 - as above

    lines = (
        [json.dumps(report.as_json(result, path), indent=2)] if wants_json else report.as_text(result, path)
    )
    try:
        for line in lines:
            print(line)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader has seen enough; nothing is left to flush at the end of the program
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":  # python -m tilesnav_validator.cli must not seem to have found nothing wrong
    sys.exit(main())

"""The command `tilesnav`: arguments and printing only."""

from __future__ import annotations

import json
import logging
import os
import signal
import sys
import traceback
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console

from tilesnav_ref.cells import CellError
from tilesnav_ref.commands.arguments import (
    UsageError,
    cell_settings,
    encode_settings,
    parse,
    scene_settings,
    town_settings,
)
from tilesnav_ref.commands.cells import cell_figures, print_cells
from tilesnav_ref.commands.info import print_figures
from tilesnav_ref.commands.path import path_figures, print_path
from tilesnav_ref.commands.path_arguments import path_settings
from tilesnav_ref.commands.planes import plane_figures, print_planes
from tilesnav_ref.commands.progress import stage_lines
from tilesnav_ref.commands.register import print_registration, registration_figures
from tilesnav_ref.commands.sample import write_sample
from tilesnav_ref.commands.scan import print_scan, scan_figures, scan_settings
from tilesnav_ref.commands.signals import Stopped, StopRequest, stop_on_signals
from tilesnav_ref.encode import encode
from tilesnav_ref.packet.model import PacketError
from tilesnav_ref.registration import RegistrationError
from tilesnav_ref.scene import SceneError
from tilesnav_ref.sensor import ScanError
from tilesnav_ref.stream.errors import RouteError, TilesetError
from tilesnav_ref.stream.figures import figures
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.tileset.errors import EncodeError, OutputError
from tilesnav_ref.tileset.folder import check_output
from tilesnav_ref.tileset.run_report import StageProgress

NOT_ENCODABLE = (CellError, EncodeError, PacketError, MemoryError)
"""Exit status 1."""
UNUSABLE = (
    UsageError, SceneError, ScanError, RegistrationError, TilesetError, RouteError, OutputError, OSError,
)  # fmt: skip
"""Exit status 2."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit status; `tilesnav --help` lists them."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    debug = "--debug" in given
    logging.basicConfig(level=logging.INFO if debug else logging.WARNING, format="%(name)s: %(message)s")
    try:
        with stop_on_signals() as request:
            _run(parse(given), request)
    except (*NOT_ENCODABLE, *UNUSABLE) as error:
        message = str(error) or "not enough memory; encode a smaller --region"
        return _fail(message, 1 if isinstance(error, NOT_ENCODABLE) else 2, debug)
    except (KeyboardInterrupt, Stopped) as stop:
        number = stop.number if isinstance(stop, Stopped) else signal.SIGINT
        kept = any(word.split("=")[0] == "--work" for word in given)
        left = "the same command goes on with the finished work" if kept else "nothing was left behind"
        return _fail(f"stopped by {number.name}; {left}", 128 + number, debug)
    except Exception as error:  # noqa: BLE001 - the one border where a defect becomes an exit status
        return _fail(f"internal error: {type(error).__name__}: {error} (--debug shows where)", 3, debug)
    return 0


def _run(given: Namespace, request: StopRequest) -> None:
    working = {
        "encode": _encode,
        "cells": _cells,
        "path": _path,
        "scan": _scan,
        "register": _register,
        "planes": _planes,
    }
    if given.command in working:
        working[given.command](given, request)
    else:
        {"info": _info, "sample": _sample}[given.command](given)


@contextmanager
def _stages(given: Namespace, request: StopRequest) -> Iterator[StageProgress]:
    """Show stages while they run; a request to stop is heeded at each step."""
    with stage_lines(Console(stderr=True), given.quiet) as show:

        def progress(stage: str, done: int, total: int) -> None:
            request.check()
            show(stage, done, total)

        yield progress


def _print(
    given: Namespace, found: dict[str, Any], as_table: Callable[[Console, dict[str, Any]], None]
) -> None:
    """Print figures as JSON, where it is asked for, or as a table."""
    with _closed_pipe_is_no_error():
        if given.json:
            print(json.dumps(found, indent=1))
        else:
            as_table(_Output(), found)


def _encode(given: Namespace, request: StopRequest) -> None:
    settings = encode_settings(given)
    check_output(given.out, given.force)
    with _stages(given, request) as progress:
        encode(given.scene, given.out, settings, given.force, progress, given.work)
    if not given.quiet:
        found = figures(open_tileset(given.out))
        with _closed_pipe_is_no_error():
            print_figures(_Output(), found)


def _cells(given: Namespace, request: StopRequest) -> None:
    settings = cell_settings(given)
    with _stages(given, request) as progress:
        found = cell_figures(given.scene, settings, given.plot, progress)
    _print(given, found, print_cells)


def _path(given: Namespace, request: StopRequest) -> None:
    try:
        settings = path_settings(given)
    except ValueError as error:
        raise UsageError(str(error)) from error
    with _stages(given, request) as progress:
        found = path_figures(given, settings, progress)
    if not given.quiet:
        with _closed_pipe_is_no_error():
            print_path(_Output(), found)


def _scan(given: Namespace, request: StopRequest) -> None:
    settings = (scene_settings(given), *scan_settings(given))
    with _stages(given, request) as progress:
        found = scan_figures(given.scene, given.out, settings, progress)
    _print(given, found, print_scan)


def _register(given: Namespace, request: StopRequest) -> None:
    with _stages(given, request) as progress:
        found = registration_figures(given, progress)
    _print(given, found, print_registration)


def _planes(given: Namespace, request: StopRequest) -> None:
    with _stages(given, request) as progress:
        found = plane_figures(given, progress)
    _print(given, found, print_planes)


def _info(given: Namespace) -> None:
    _print(given, figures(open_tileset(given.tileset)), print_figures)


def _sample(given: Namespace) -> None:
    written = write_sample(given.out, town_settings(given))
    with _closed_pipe_is_no_error():
        print(written)


class _Output(Console):
    """Standard output; rich would end the process with status 1 where a pipe has been closed."""

    def on_broken_pipe(self) -> None:
        """Leave the decision to the command."""
        raise BrokenPipeError


@contextmanager
def _closed_pipe_is_no_error() -> Iterator[None]:
    """Print until the reader has seen enough, as `head` has after some lines; the work is done by then."""
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:  # what is left in the buffer must not raise again at the end of the program
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: str, status: int, debug: bool) -> int:
    if debug:
        traceback.print_exc()
    print(f"tilesnav: error: {' '.join(message.split())}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())

"""What a run tells while it works."""

from __future__ import annotations

import io

from rich.console import Console

from tilesnav_ref.commands.progress import LINE_SECONDS, PlainLines, stage_lines


def _console(terminal: bool = False) -> tuple[Console, io.StringIO]:
    text = io.StringIO()
    return Console(file=text, force_terminal=terminal, width=100), text


def test_lines_come_now_and_then_and_tell_the_rest() -> None:
    console, text = _console()
    now = [1000.0]
    lines = PlainLines(console, lambda: now[0])
    for step in range(1, 11):
        lines("visibility", step, 10)
        now[0] += LINE_SECONDS / 2
    assert text.getvalue().splitlines() == [
        "see from every cell: 30%, 30 s, about 70 s more",
        "see from every cell: 50%, 60 s, about 60 s more",
        "see from every cell: 70%, 90 s, about 39 s more",
        "see from every cell: 90%, 120 s, about 13 s more",
    ]


def test_short_stages_have_no_line_and_stages_are_timed_apart() -> None:
    console, text = _console()
    now = [0.0]
    lines = PlainLines(console, lambda: now[0])
    lines("scene", 0, 1)
    now[0] += 0.9 * LINE_SECONDS
    lines("scene", 1, 1)
    now[0] += 0.9 * LINE_SECONDS
    lines("cells", 1, 4)
    assert text.getvalue() == ""
    now[0] += LINE_SECONDS
    lines("cells", 2, 4)
    assert text.getvalue() == "cover the navigable space: 50%, 30 s, about 30 s more\n"


def test_a_terminal_has_bars_and_quiet_is_quiet() -> None:
    console, text = _console(terminal=True)
    with stage_lines(console, quiet=False) as show:
        show("visibility", 0, 8)
        show("visibility", 8, 8)
    assert "see from every cell" in text.getvalue()
    assert "100%" in text.getvalue()
    console, text = _console(terminal=True)
    with stage_lines(console, quiet=True) as show:
        show("visibility", 8, 8)
    assert text.getvalue() == ""

"""From nothing to a verdict: write the sample town, encode it, validate it, and say what lies where.

Usage: python tools/demo.py FOLDER
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.table import Table

SAMPLE = ("--size", "small", "--detail", "coarse")
RAYS = 1_000_000
"""Rays of the validator's search for a face that is missing."""

console = Console(width=100)


def run(title: str, module: str, *arguments: str | Path, allowed: tuple[int, ...] = (0,)) -> str:
    """Run a command of ours, say how long it took, and return what it printed on standard output."""
    console.print(f"[bold]{title}[/bold]  {module} {' '.join(map(str, arguments))}", soft_wrap=True)
    begin = perf_counter()
    command = [sys.executable, "-m", module, *map(str, arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False, stdin=subprocess.DEVNULL)
    if done.returncode not in allowed:
        console.print(done.stdout)
        raise SystemExit(done.returncode)
    console.print(f"  {perf_counter() - begin:.1f} s")
    return done.stdout


def verdict_table(report: dict[str, Any]) -> Table:
    """Count the requirements by verdict, and name those that fail."""
    table = Table("verdict", "requirements", title="What tilesnav-validate says")
    by_verdict: dict[str, list[str]] = {}
    for one in report["requirements"]:
        by_verdict.setdefault(one["verdict"], []).append(one["id"])
    for verdict, names in sorted(by_verdict.items()):
        table.add_row(verdict, f"{len(names)}" + ("" if verdict == "pass" else ": " + ", ".join(names)))
    return table


def place_table(folder: Path) -> Table:
    """Say what was made and where to look."""
    table = Table("where", "what", title="Where to look")
    rows = {
        "town.glb": "the sample town; any viewer of meshes opens it",
        "tileset/tileset.json": "the entry tileset; any 3D Tiles 1.1 viewer opens it",
        "tileset/contents": "the mesh as binary glTF",
        "tileset/nav": "cells, portals, sets, levels, deltas, and the proofs of the sets",
        "verdict.json": "the whole report of the validator",
    }
    for name, meaning in rows.items():
        table.add_row(str(folder / name), meaning)
    return table


def main() -> int:
    """Run the demo."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    scene, tileset, verdict = folder / "town.glb", folder / "tileset", folder / "verdict.json"
    scene.unlink(missing_ok=True)
    run("1. a town", "tilesnav_ref.cli", "sample", scene, *SAMPLE)
    figures = run("2. encode", "tilesnav_ref.cli", "encode", scene, tileset, "--force", "--certificates")
    judge = (tileset / "tileset.json", "--json", "--rays", str(RAYS))
    report = json.loads(run("3. validate", "tilesnav_validator", *judge, allowed=(0, 1)))
    verdict.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    sys.stdout.write(figures)
    sys.stdout.flush()
    console.print(verdict_table(report))
    console.print(place_table(folder))
    console.print(f"The tileset is [bold]{report['verdict']}[/bold].")
    return 0 if report["verdict"] == "valid" else 1


if __name__ == "__main__":
    sys.exit(main())

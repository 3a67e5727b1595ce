"""Use both installed commands as a user would: sample, encode, info, validate, and validate what is damaged.

Usage: python use_wheels.py TILESNAV TILESNAV_VALIDATE FOLDER
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

VALID, INVALID, UNREADABLE = 0, 1, 2


def expect(status: int, *command: str | Path) -> str:
    """Run a command; end with a message when it exits with another status."""
    done = subprocess.run(
        list(map(str, command)), capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL
    )
    if done.returncode != status:
        text = " ".join(map(str, command))
        sys.exit(f"{text}\nexit status {done.returncode}, expected {status}\n{done.stdout}{done.stderr}")
    return done.stdout


def main() -> None:
    """Run both programs in their own environments."""
    tilesnav, judge, folder = sys.argv[1], sys.argv[2], Path(sys.argv[3])
    folder.mkdir()
    scene, out = folder / "town.ply", folder / "tileset"
    few = ("--rays", "500", "--attempts", "4", "--min-cell", "8", "--max-cell", "32")
    expect(0, tilesnav, "sample", scene, "--size", "small", "--detail", "coarse")
    expect(0, tilesnav, "encode", scene, out, "--quiet", *few)
    figures = json.loads(expect(0, tilesnav, "info", out, "--json"))
    entry = out / "tileset.json"
    expect(VALID, judge, entry, "--rays", "10000")
    nav = min((out / "nav").iterdir())
    nav.write_bytes(nav.read_bytes()[:-8])
    expect(INVALID, judge, entry, "--rays", "0")
    entry.unlink()
    expect(UNREADABLE, judge, entry)
    print(f"wheels: {figures['cells']} cells encoded by one, judged by the other")


if __name__ == "__main__":
    main()

"""Install the pinned npm packages of tests/external into build/ and print the folder.

The folder is named by the digest of the lock file, so that another lock means another folder and an installed
one is never changed. npm gets a folder of its own that is renamed when it is complete.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "tests" / "external"
CACHE = ROOT / "build" / "external"
PACKAGE_FILES = ("package.json", "package-lock.json")
OLDEST_NODE = (20, 19)
"""The oldest node that the pinned cesium declares support for."""


def why_not() -> str | None:
    """Return why the packages cannot be used on this machine, or None where they can."""
    for program in ("node", "npm"):
        if shutil.which(program) is None:
            return f"{program} is not installed"
    version = subprocess.run(["node", "--version"], check=True, capture_output=True, text=True).stdout.strip()
    found = tuple(int(part) for part in version.removeprefix("v").split(".")[:2])
    if found < OLDEST_NODE:
        return f"node {version} is older than {'.'.join(map(str, OLDEST_NODE))}"
    return None


def install() -> Path:
    """Return the folder with node_modules and the scripts; install what is missing there.

    Raises
    ------
    subprocess.CalledProcessError
        When npm fails; its output is on standard error.
    """
    digest = hashlib.sha256(b"".join((SOURCE / name).read_bytes() for name in PACKAGE_FILES)).hexdigest()
    folder = CACHE / digest[:16]
    if not folder.is_dir():
        CACHE.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=CACHE) as name:
            fresh = Path(name) / "fresh"
            fresh.mkdir()
            for package_file in PACKAGE_FILES:
                shutil.copy(SOURCE / package_file, fresh)
            command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"]
            subprocess.run(command, cwd=fresh, check=True, stdin=subprocess.DEVNULL, stdout=sys.stderr)
            if not folder.is_dir():  # another run may have been faster
                fresh.rename(folder)
    for script in SOURCE.glob("*.mjs"):
        copy = folder / f".{script.name}.{os.getpid()}"
        shutil.copy(script, copy)
        copy.replace(folder / script.name)
    return folder


def main() -> int:
    """Install and print the folder."""
    reason = why_not()
    if reason is not None:
        print(reason, file=sys.stderr)
        return 2
    print(install())
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""The decorator of compiled kernels, and where their machine code is kept.

Numba's file cache is keyed by the file of the decorated function alone: a kernel that calls a changed kernel
of another file would go on with the old one. A stale proof is no proof, so the cache folder carries a digest
of every source file of the package (scene, cells, ...) that the kernel lives in. Kernels therefore use names
of their own package only; a test holds them to that.
"""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba import njit
from numba.core.options import DefaultOptions

UNCOUNTED: dict[str, Any] = {"_nrt": False} if hasattr(DefaultOptions, "_nrt") else {}
"""Option without a promise to stay; without it, kernels are slower and do the same."""

logger = logging.getLogger(__name__)


def package_digest(package: Path) -> str:
    """Digest of the source files in a package folder, in the order of their names."""
    digest = hashlib.sha256()
    for source in sorted(package.glob("*.py")):
        digest.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()


@cache
def cache_folder(package: Path) -> Path | None:
    """Folder for machine code of exactly the sources in `package`, or None when no folder can be written.

    ``NUMBA_CACHE_DIR`` or the user's cache folder (``XDG_CACHE_HOME``, else ``~/.cache``) is its parent.
    """
    parent = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(parent) / "tilesnav" / f"{package.name}-{package_digest(package)[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        logger.warning("kernels are compiled anew in each run: cannot write %s (%s)", folder, error)
        return None
    return folder


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function with numba: no Python objects, no fast-math, no global lock, cached on disk."""
    return _compiled(function)


def inner_kernel(function: Callable[..., Any]) -> Any:
    """Compile a function as `kernel` does, as part of every kernel that calls it.

    For what is called in inner loops: numba hands over arrays, and tuples of arrays, word by word, which
    costs more than a small function does.
    """
    return _compiled(function, forceinline=True)


def plain_kernel(function: Callable[..., Any]) -> Any:
    """Compile a function as `kernel` does, for functions that make and return no arrays.

    Numba counts the references to every array that a function takes out of a tuple, atomically, which costs
    more than a look-up in a table does. What makes no array and returns none, not even a view, can do
    without; one that returned an array would free it under the feet of its caller.
    """
    return _compiled(function, **UNCOUNTED)


def plain_inner_kernel(function: Callable[..., Any]) -> Any:
    """Compile a function as `inner_kernel` and `plain_kernel` do."""
    return _compiled(function, forceinline=True, **UNCOUNTED)


def _compiled(function: Callable[..., Any], **options: Any) -> Any:
    folder = cache_folder(Path(function.__code__.co_filename).parent)
    if folder is None:
        return njit(nogil=True, **options)(function)
    config: Any = numba.config
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)  # read once, when the decorator sets the function's cache up
    try:
        return njit(cache=True, nogil=True, **options)(function)
    finally:
        config.CACHE_DIR = before

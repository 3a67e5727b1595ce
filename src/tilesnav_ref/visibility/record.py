"""Writing proofs down while they are found, as words of int32.

A proof is ``targets, n, target 1 .. target n``, then ``words, w`` and w words: the tree of cuts in preorder,
where -code stands for a cut and m > 0 for a leaf, followed by the m faces of its occluder.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

USED, OPEN, LOST = 0, 1, 2
"""Positions in `Record.state`: words of finished proofs, words with the proof in progress, words that did
not fit."""


class Record(NamedTuple):
    """Proofs of one thread; without words nothing is recorded."""

    words: NDArray[np.int32]
    """(capacity,)."""
    state: NDArray[np.int64]
    """(3,) see USED, OPEN and LOST."""


def make_record(capacity: int) -> Record:
    """Room for so many words; 0 turns recording off."""
    return Record(np.zeros(capacity, np.int32), np.zeros(3, np.int64))


def take(record: Record) -> NDArray[np.int32]:
    """Return the words of the finished proofs and forget them."""
    words = record.words[: record.state[USED]].copy()
    record.state[:] = 0
    return words


def is_full(record: Record) -> bool:
    """Whether words did not fit, so that proofs are missing."""
    return bool(record.state[LOST] > 0)


@kernel
def put(record, word):  # type: ignore[no-untyped-def]
    """Append a word to the proof in progress."""
    if record.state[OPEN] < len(record.words):
        record.words[record.state[OPEN]] = word
        record.state[OPEN] += 1
    else:
        record.state[LOST] += 1


@kernel
def set_word(record, place, word):  # type: ignore[no-untyped-def]
    """Change a word that was put before."""
    if place < len(record.words):
        record.words[place] = word


@kernel
def begin(record, targets):  # type: ignore[no-untyped-def]
    """Begin a proof for some faces (n,); one in progress that was not finished is dropped."""
    if len(record.words) == 0:
        return
    record.state[OPEN] = record.state[USED]
    put(record, len(targets))
    for target in targets:
        put(record, target)
    put(record, 0)


@kernel
def put_cut(record, code):  # type: ignore[no-untyped-def]
    """A cut of the pair of parts at hand."""
    if len(record.words) > 0:
        put(record, -code)


@kernel
def finish(record):  # type: ignore[no-untyped-def]
    """The proof in progress is complete."""
    if len(record.words) == 0 or record.state[LOST] > 0:
        return
    head = record.state[USED]
    at = head + 1 + record.words[head]
    record.words[at] = record.state[OPEN] - at - 1
    record.state[USED] = record.state[OPEN]

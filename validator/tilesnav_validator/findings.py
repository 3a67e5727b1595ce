"""What checks hand to the runner, and what a run is asked to do."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any


class UnreadableInputError(Exception):
    """The entry tileset cannot be read at all: exit status 2."""


@dataclass(frozen=True)
class Settings:
    """What a run is asked to do.

    Attributes
    ----------
    rays : int
        Number of rays of the search for missing faces, half of them uniform; 0 leaves the search out.
    seed : int
        Seed of everything random.
    threads : int
        Number of threads that cast rays. Results do not depend on it.
    lod_pairs : int
        Most pairs of a cell and a face that the LOD checks look at; beyond, a seeded choice of cells.
    proof_pairs : int
        Most pairs of a leaf and a face of its occluder, and of a use and a target, that are looked at in one
        certificate file; a short file may ask for more than anyone has time for.
    packets : tuple of Path
        Sequences of packets to judge as well, each by itself; without them the class packet is not judged.
    packet_bytes : int
        Most bytes of states in their canonical form that packets may lead through; a short file may repeat
        a large state without end.
    packet_memory : int
        Most bytes of states that later packets apply to, at once.
    """

    rays: int = 1_000_000
    seed: int = 0
    threads: int = 2
    lod_pairs: int = 4_000_000
    proof_pairs: int = 2**31
    packets: tuple[Path, ...] = ()
    packet_bytes: int = 2**36
    packet_memory: int = 2**31


@dataclass(frozen=True)
class Finding:
    """One place where a requirement does not hold.

    Attributes
    ----------
    where : str
        JSON pointer, table and index, or cell number.
    measured, allowed : str
        What was found, and what the requirement allows.
    witness : dict, optional
        Numbers with which the finding can be verified by hand.
    """

    where: str
    measured: str
    allowed: str
    witness: dict[str, Any] | None = None


@dataclass(frozen=True)
class NotRefuted:
    """Outcome of a check that searched for a counterexample and cannot be complete."""

    basis: str


@dataclass(frozen=True)
class NotRun:
    """Outcome of a check that found nothing to look at."""

    reason: str


Outcome = NotRefuted | NotRun | None
Findings = Generator[Finding, None, Outcome]
"""A check that ends with an outcome; others are plain iterators of findings, and their outcome is None."""

Check = Callable[..., Iterator[Finding]]

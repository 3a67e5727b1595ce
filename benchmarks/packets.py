"""Packets along random walks through a tileset: bytes, and the time to make and to apply one.

Usage: python benchmarks/packets.py TILESET [--walks 4] [--hops 50] [--retain 0 5000] [--policy fine auto]

A walk starts in a random cell and passes through portals, back only from dead ends. Times are those of the
processor, so that other programs disturb them less; what is compiled is not counted.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tilesnav_ref.packet.client import PacketClient, Verdict
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.packet.wire import HEADER, read_packet
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.stream.sender import Sender

COLUMNS = (
    "policy",
    "retain",
    "packets",
    "key frames",
    "bytes a hop",
    "median",
    "90 %",
    "faces entering",
    "bytes a face",
    "header, %",
    "faces held",
    "making, ms",
    "90 %",
    "applying, ms",
    "90 %",
)


@dataclass(frozen=True)
class Row:
    """One packet that was applied."""

    size: int
    is_key_frame: bool
    entered: int
    """Faces that the vehicle did not hold."""
    held: int
    made: float
    """Processor seconds to make it."""
    applied: float
    """Processor seconds to read, decode, check and mark it."""


def walk(tileset: NavTileset, hops: int, seed: int) -> list[int]:
    """Cells of a random walk."""
    random = np.random.default_rng(seed)
    cells = [int(random.integers(tileset.cell_count))]
    for _ in range(hops):
        last = cells[-2:-1]
        ways = tileset.neighbours(cells[-1]).tolist()
        ahead = [cell for cell in ways if cell not in last] or ways
        if not ahead:
            break
        cells.append(int(random.choice(ahead)))
    return cells


def entered(before: HeldState | None, after: HeldState) -> int:
    """Faces of a state that another lacks."""
    held = {} if before is None else {(p.object, p.level): p.faces for p in before.parts}
    none = np.empty(0, np.uint32)
    return sum(len(np.setdiff1d(p.faces, held.get((p.object, p.level), none))) for p in after.parts)


def follow(delivery: Delivery, policy: LevelPolicy, retain: int, cells: list[int]) -> Iterator[Row]:
    """Lead a vehicle along a path; every packet arrives and is acknowledged."""
    sender, client = Sender(delivery, policy, retain), PacketClient(delivery.map_name)
    for cell in cells:
        before = client.state
        started = time.process_time()
        data = sender.packet(cell)
        made = time.process_time()
        outcome = client.receive(data)
        applied = time.process_time()
        if outcome.verdict is Verdict.REFUSED or client.state is None or not sender.acknowledge(client.holds):
            raise SystemExit(f"cell {cell}: {outcome}")
        yield Row(
            len(data),
            read_packet(data).is_key_frame,
            entered(before, client.state),
            client.state.face_count,
            made - started,
            applied - made,
        )


def spread(values: list[float]) -> str:
    """Median and 90th percentile."""
    return "{:.1f} | {:.1f}".format(*np.percentile(values, [50, 90]))


def line(policy: str, retain: int, rows: list[Row]) -> str:
    """A row of the table."""
    size, new = sum(row.size for row in rows), sum(row.entered for row in rows)
    cells = (
        policy,
        str(retain),
        str(len(rows)),
        str(sum(row.is_key_frame for row in rows)),
        f"{size / len(rows):.0f}",
        spread([row.size for row in rows]),
        f"{new / len(rows):.0f}",
        f"{size / max(new, 1):.2f}",
        f"{100 * HEADER.size * len(rows) / size:.1f}",
        f"{np.mean([row.held for row in rows]):.0f}",
        spread([1e3 * row.made for row in rows]),
        spread([1e3 * row.applied for row in rows]),
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tileset", type=Path)
    parser.add_argument("--walks", type=int, default=4)
    parser.add_argument("--hops", type=int, default=50)
    parser.add_argument("--retain", type=int, nargs="*", default=[0, 5000])
    parser.add_argument("--policy", nargs="*", default=["fine", "auto"])
    arguments = parser.parse_args()
    delivery = Delivery(open_tileset(arguments.tileset))
    paths = [walk(delivery.tileset, arguments.hops, seed) for seed in range(arguments.walks)]
    list(follow(delivery, LevelPolicy("fine"), 0, paths[0][:3]))  # compile
    print(f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}")
    for policy in arguments.policy:
        for retain in arguments.retain:
            rows = [
                row for path in paths for row in list(follow(delivery, LevelPolicy(policy), retain, path))[1:]
            ]
            print(line(policy, retain, rows), flush=True)


if __name__ == "__main__":
    main()

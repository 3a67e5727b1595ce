"""The figures of a tileset as tables for people."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table


def print_figures(console: Console, figures: dict[str, Any]) -> None:
    """Print the figures that :func:`tilesnav_ref.stream.figures.figures` gives."""
    console.print(_overview(figures))
    console.print(_bytes(figures["bytes"]))
    if figures["seconds"]:
        console.print(_seconds(figures))


def _overview(figures: dict[str, Any]) -> Table:
    pvs, delta = figures["pvs"], figures["delta"]
    table = _table("figure", "value")
    rows = (
        ("cells", f"{figures['cells']:,} ({figures['ground_cells']:,} ground), {figures['volume']:,.0f} m3"),
        ("coverage", _share(figures["coverage"])),
        ("clearance", f"{figures['clearance']:g} m"),
        ("portals, directed", f"{figures['portals']:,}"),
        (
            "faces",
            f"{figures['faces']:,} in {figures['objects']:,} objects, {figures['contents']:,} contents",
        ),
        (
            "faces in the set of a cell",
            f"mean {pvs['mean']:,.1f}, 95 % {pvs['p95']:,.0f}, max {pvs['max']:,}",
        ),
        ("of them proven visible", f"mean {pvs['proven_mean']:,.1f}"),
        ("overestimate", "unknown" if pvs["overestimate"] is None else f"{pvs['overestimate']:.3f}"),
        (
            "delta of a portal",
            f"{delta['mean_entered']:,.1f} faces entered, {delta['mean_switched']:,.1f} switched",
        ),
    )
    for row in rows:
        table.add_row(*row)
    for row in _limits(figures):
        table.add_row(*row)
    for reason, count in (figures["undecided"] or {}).items():
        table.add_row(f"undecided: {reason}", f"{count:,}")
    return table


def _limits(figures: dict[str, Any]) -> list[tuple[str, str]]:
    """Rows on what bounds visibility, where anything does, and on an update."""
    rows = []
    if figures["update"]:
        kept = figures["update"].get("cellsKept", "unknown")
        rows.append(("cells kept from an earlier tileset", f"{kept}"))
    if figures["max_range"] is not None:
        rows.append(("range", f"{figures['max_range']:g} m"))
    for kind in ("porous", "one_sided"):
        if figures[f"{kind}_objects"]:
            rows.append((f"objects, {kind.replace('_', '-')}", f"{figures[f'{kind}_objects']:,}"))
    return rows


def _bytes(sizes: dict[str, Any]) -> Table:
    table = _table("part", "bytes")
    coarse = {"coarse levels": sizes["coarse"]} if sizes["coarse"] else {}
    nav = {f"nav {group}": n for group, n in sizes["nav"].items()}
    parts = {"contents": sizes["contents"], **coarse, **nav}
    proofs = {"certificates": sizes["certificates"]} if sizes["certificates"] else {}
    for part, size in {**parts, **proofs, "tileset.json": sizes["json"], "total": sizes["total"]}.items():
        table.add_row(part, f"{size:,}")
    return table


def _seconds(figures: dict[str, Any]) -> Table:
    table = _table("stage", "seconds")
    for stage, seconds in figures["seconds"].items():
        table.add_row(stage, f"{seconds:,.2f}")
    table.add_row("all", f"{sum(figures['seconds'].values()):,.2f}")
    if figures["peak_memory"]:
        table.add_row("peak memory", f"{figures['peak_memory'] / 2**20:,.0f} MiB")
    return table


def _table(left: str, right: str) -> Table:
    table = Table()
    table.add_column(left)
    table.add_column(right, justify="right")
    return table


def _share(value: float | None) -> str:
    return "unknown" if value is None else f"{100 * value:.2f} %"

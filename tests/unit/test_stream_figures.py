"""Figures of a small map, worked out by hand; volumes of cells that are no boxes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_tileset_coarse import coarse_map
from test_tileset_small_map import small_map

from tilesnav_ref.cells import planes
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.figures import figures
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.stream.volume import cell_volumes
from tilesnav_ref.tileset.model import TilesetSettings
from tilesnav_ref.tileset.run_report import Stopwatch, run_report, write_report
from tilesnav_ref.tileset.write import write_tileset

BOX = np.array(
    [[-1, 0, 0, 1.0], [1, 0, 0, -3.0], [0, -1, 0, 1.0], [0, 1, 0, -3.0], [0, 0, -1, 1.0], [0, 0, 1, -3.0]]
)


def _write(folder: Path, cells_per_sector: int) -> Path:
    one = small_map()
    write_tileset(folder, one, planes(one.cells, one.scene.step), TilesetSettings(cells_per_sector))
    return folder


def test_files_of_coarse_levels_count(tmp_path: Path) -> None:
    write_tileset(tmp_path, coarse_map(), planes(small_map().cells, 2.0**-10), TilesetSettings())
    found = figures(open_tileset(tmp_path))
    files = [p for p in tmp_path.rglob("*") if p.is_file()]
    assert found["coarse_levels"] == 2
    assert found["bytes"]["coarse"] == sum(p.stat().st_size for p in files if "-" in p.name)
    assert found["bytes"]["total"] == sum(p.stat().st_size for p in files)


@pytest.mark.parametrize("cells_per_sector", [2, 3])
def test_figures_of_the_small_map(tmp_path: Path, cells_per_sector: int) -> None:
    found = figures(open_tileset(_write(tmp_path, cells_per_sector)))
    assert [found[name] for name in ("cells", "ground_cells", "portals", "faces", "objects", "contents")] == [
        *(3, 2, 4, 5, 3, 2)
    ]
    assert found["volume"] == 24.0
    assert found["coverage"] == 0.75
    # Sets of 3, 4 and 1 faces, of which 2, 3 and 1 are proven visible.
    assert found["pvs"] == {
        "mean": pytest.approx(8 / 3),
        "p95": pytest.approx(3.9),
        "max": 4,
        "proven_mean": 2.0,
        "overestimate": pytest.approx(8 / 6),
    }
    assert (found["delta"]["mean_entered"], found["delta"]["mean_left"]) == (6 / 4, 6 / 4)
    assert found["delta"]["mean_switched"] == 5 / 4
    files = sum(p.stat().st_size for p in tmp_path.rglob("*") if p.is_file())
    assert found["bytes"]["total"] == files
    nav = found["bytes"]["nav"]
    assert sum(nav.values()) == sum(p.stat().st_size for p in (tmp_path / "nav").iterdir())
    assert nav["deltas"] == found["delta"]["bytes"]
    assert (found["coarse_levels"], found["bytes"]["coarse"]) == (0, 0)


def test_a_single_sector_has_the_bytes_of_its_tables(tmp_path: Path) -> None:
    nav = figures(open_tileset(_write(tmp_path, 3)))["bytes"]["nav"]
    # Offsets of 5 portals' ends, thrice; 6 faces entered, 6 left; 5 objects and 5 codes.
    assert nav["deltas"] == 3 * 5 * 4 + 6 * 4 + 6 * 4 + 5 * 4 + 5
    assert nav["cells"] == 3 * 6 * 4 * 8 + 3


def test_time_and_memory_come_from_the_side_file(tmp_path: Path) -> None:
    _write(tmp_path, 3)
    without = figures(open_tileset(tmp_path))
    assert (without["seconds"], without["peak_memory"]) == (None, None)
    seen: list[tuple[str, int, int]] = []
    watch = Stopwatch(lambda name, done, total: seen.append((name, done, total)))
    with watch.stage("cells") as steps:
        steps(2, 5)
    write_report(tmp_path, run_report(watch))
    found = figures(open_tileset(tmp_path))
    assert list(found["seconds"]) == ["cells"]
    assert found["peak_memory"] > 2**20
    assert seen == [("cells", 0, 1), ("cells", 2, 5), ("cells", 1, 1)]


def test_a_broken_side_file_is_an_error(tmp_path: Path) -> None:
    (_write(tmp_path, 3) / "encode-report.json").write_text("{")
    with pytest.raises(TilesetError, match="no JSON"):
        figures(open_tileset(tmp_path))


def _turned(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    turned = BOX.copy()
    turned[:, :3] = BOX[:, :3] @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return turned


def test_volumes() -> None:
    frustum = BOX.copy()
    # Four sides lean inwards by 45 degrees above the square of side 2 around (2, 2, 1): a pyramid, cut at
    # half its height.
    frustum[:4, :3] = (BOX[:4, :3] + [0, 0, 1]) / np.sqrt(2)
    frustum[:4, 3] = -frustum[:4, :3] @ np.array([2.0, 2.0, 2.0])
    frustum[5, 3] = -1.5
    empty = BOX.copy()
    empty[1, 3] = -0.5
    flat = _turned(0.3)
    flat[5, 3] = -1.0
    volumes = cell_volumes(np.stack([BOX, BOX[::-1], _turned(0.3), frustum, empty, flat]))
    # The pyramid has the volume 4/3; the part above the cut is an eighth of it.
    assert volumes == pytest.approx([8, 8, 8, 4 / 3 * 7 / 8, 0, 0])

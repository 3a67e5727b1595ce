"""Driving a route: what is sent adds up, and the client holds in every cell what is delivered there."""

from __future__ import annotations

import numpy as np
import pytest
from delivery_fixture import random_map, written

from tilesnav_ref.packet.client import PacketClient, Verdict
from tilesnav_ref.packet.state import same_part
from tilesnav_ref.packet.wire import read_packet
from tilesnav_ref.stream.baseline import ScreenSettings
from tilesnav_ref.stream.comparison import ComparisonSettings, ContentSizes, object_tree, rivals
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.drive import UNLIMITED, DriveSettings, drive
from tilesnav_ref.stream.path import find_route
from tilesnav_ref.stream.policy import NAMES, LevelPolicy
from tilesnav_ref.stream.reader import NavTileset
from tilesnav_ref.stream.route import Route
from tilesnav_ref.stream.tiles import read_tiles

WAY = ((1.5, 2.0, 2.0), (6.5, 2.0, 2.0), (4.0, 1.5, 2.5), (2.0, 2.0, 2.0))
"""There and back through the three cells."""


@pytest.fixture(scope="module", params=[1, 2])
def tileset(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> NavTileset:
    return written(tmp_path_factory.mktemp("drive") / "out", random_map(request.param))


@pytest.fixture(scope="module")
def route(tileset: NavTileset) -> Route:
    return find_route(tileset, WAY)


@pytest.mark.parametrize("retain", [0, 3, UNLIMITED])
@pytest.mark.parametrize("name", NAMES)
def test_the_client_holds_what_is_delivered(
    tileset: NavTileset, route: Route, name: str, retain: int
) -> None:
    delivery, policy = Delivery(tileset), LevelPolicy(name)
    driven = drive(delivery, route, DriveSettings(policy, 2.0, retain))
    assert driven.cells.tolist() == [0, 1, 2, 1, 0]
    assert driven.series.sizes.tolist() == [len(packet) for packet in driven.packets]
    assert driven.series.total == len(b"".join(driven.packets))
    assert driven.series.times.tolist() == [passage.begin / 2.0 for passage in route.passages]
    assert driven.series.duration == pytest.approx(route.length / 2.0)
    assert driven.key_frames.tolist() == [read_packet(packet).is_key_frame for packet in driven.packets]
    client, before = PacketClient(delivery.map_name), 0
    for row, packet in enumerate(driven.packets):
        assert client.receive(packet).verdict is Verdict.APPLIED
        state = client.state
        assert state is not None
        assert (state.cell, state.face_count) == (driven.cells[row], driven.series.held[row])
        needed = delivery.held(int(driven.cells[row]), policy)
        if retain == 0:
            assert len(state.parts) == len(needed)
            assert all(map(same_part, state.parts, needed))
            assert driven.new_faces[row] >= state.face_count - before
        assert sum(len(part.faces) for part in needed) <= state.face_count + (retain > 0) * 1000
        assert {part.object for part in needed} <= {part.object for part in state.parts}
        before = state.face_count


def test_who_drops_nothing_receives_nothing_twice(tileset: NavTileset) -> None:
    delivery = Delivery(tileset)
    # Not through cell 0, where nothing is seen: a key frame of nothing is less than any change.
    there_and_back = find_route(tileset, ((4.0, 2.0, 2.0), (6.5, 2.0, 2.0), (4.0, 2.0, 2.0), (6.5, 2.0, 2.0)))
    driven = drive(delivery, there_and_back, DriveSettings(LevelPolicy("fine"), 20.0, UNLIMITED))
    assert driven.cells.tolist() == [1, 2, 1, 2]
    assert driven.new_faces[2:].tolist() == [0, 0]
    dropping = drive(delivery, there_and_back, DriveSettings(LevelPolicy("fine"), 20.0))
    assert dropping.new_faces.sum() > driven.new_faces.sum()
    assert np.all(driven.series.held >= dropping.series.held)


@pytest.mark.parametrize(("speed", "retain"), [(0.0, 0), (-5.0, 0), (float("nan"), 0), (2e3, 0), (20.0, -1)])
def test_settings_out_of_range_are_named(speed: float, retain: int) -> None:
    with pytest.raises(ValueError, match=r"setting (speed|retain): found"):
        DriveSettings(speed=speed, retain=retain)


def test_rivals_load_what_their_trees_say(tileset: NavTileset, route: Route) -> None:
    settings = ComparisonSettings(ScreenSettings(0.001), sensor_range=1000.0, spacing=0.5)
    found = {rival.name: rival for rival in rivals(Delivery(tileset), route, 2.0, settings)}
    assert list(found) == [
        f"{kind}-{memory}" for kind in ("tiles", "objects", "range") for memory in ("drop", "keep")
    ]
    # So few pixels show everything at the finest level, from everywhere: all comes at the start, and stays.
    files = sum(content.path.stat().st_size for content in tileset.contents)
    for name, rival in found.items():
        assert rival.coded.total == rival.coded.first > 0
        assert set(rival.coded.held) == {tileset.face_count}
        assert (rival.files is not None) == name.startswith("tiles")
        assert rival.coded.duration == pytest.approx(route.length / 2.0)
    tiles = found["tiles-drop"].files
    assert tiles is not None
    assert tiles.total == files
    assert found["objects-drop"].coded.total == found["range-drop"].coded.total


def test_who_keeps_loads_no_more_than_who_drops(tileset: NavTileset, route: Route) -> None:
    settings = ComparisonSettings(ScreenSettings(300.0), sensor_range=3.0, spacing=0.25)
    found = {rival.name: rival.coded for rival in rivals(Delivery(tileset), route, 2.0, settings)}
    for kind in ("tiles", "objects", "range"):
        dropping, keeping = found[f"{kind}-drop"], found[f"{kind}-keep"]
        assert keeping.first == dropping.first
        assert keeping.total <= dropping.total
        assert np.all(keeping.held >= dropping.held)


def test_tiles_of_objects_bound_their_levels_and_their_errors_fall(tileset: NavTileset) -> None:
    tree = object_tree(tileset)
    assert tree.count == 1 + 3 * tileset.object_count
    errors = tree.errors[1:].reshape(-1, 3)
    assert np.all(errors[:, :-1] >= errors[:, 1:])
    assert np.all(errors[:, -1] == 0.0)
    assert np.all(errors[:, 1] == tileset.levels[0].errors)
    assert tree.parents.tolist()[:5] == [-1, 0, 1, 2, 0]
    for tile, contents in enumerate(tree.contents):
        for content in contents:
            geometry = tileset.levels[content.level - 1].geometry if content.level else tileset.finest
            first, last = geometry.offsets[content.content_id : content.content_id + 2]
            corners = geometry.corners[first:last].reshape(-1, 3) * tileset.step
            assert np.all(np.abs(corners - tree.centres[tile]) <= np.diag(tree.axes[tile]) + 1e-12)


def test_sizes_of_contents_are_those_of_their_faces(tileset: NavTileset) -> None:
    sizes, tree = ContentSizes(tileset), read_tiles(tileset.path)
    contents = [content for tile in tree.contents for content in tile]
    assert {content.level for content in contents} == {0, 1, 2}
    for level, total in (
        (0, tileset.face_count),
        *((one.level, int(one.geometry.offsets[-1])) for one in tileset.levels),
    ):
        assert sum(sizes.faces(one) for one in contents if one.level == level) == total
    for content in contents:
        assert content.path is not None
        assert sizes.file(content) == content.path.stat().st_size
        assert 0 < sizes.coded(content) < sizes.file(content)


@pytest.mark.parametrize("values", [{"sensor_range": 0.0}, {"spacing": float("nan")}])
def test_comparisons_out_of_range_are_named(values: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"setting (sensor_range|spacing): found"):
        ComparisonSettings(**values)

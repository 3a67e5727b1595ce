"""The sample town: closed buildings on the ground, no junctions, the sizes that were asked for."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tilesnav_ref.scene import SceneError
from tilesnav_ref.scene.noding import count_junctions
from tilesnav_ref.scene.sample import DETAILS, TRAINING_SITE, TownSettings, make_town
from tilesnav_ref.scene.sample.canvas import Terrain
from tilesnav_ref.scene.sample.plan import make_plan
from tilesnav_ref.scene.sample.settings import METRE, UNIT
from tilesnav_ref.scene.topology import edge_keys
from tilesnav_ref.scene.weld import has_area

SETTINGS = [
    TownSettings(detail=d, sloped=s, seed=n)
    for n, (d, s) in enumerate(itertools.product(DETAILS, (False, True)))
]
SMALL = [
    pytest.param(s, id=f"{s.detail}-{s.sloped}", marks=[pytest.mark.jit] if s.detail == "fine" else [])
    for s in SETTINGS
]


def buildings(scene) -> dict[str, np.ndarray]:
    """Faces of every building by its name, pieces together."""
    owner = [name.split("/")[0] for name in scene.object_names]
    faces = scene.faces.astype(np.int64)
    return {
        name: faces[np.isin(scene.face_object, [k for k, o in enumerate(owner) if o == name])]
        for name in sorted(set(owner))
        if not name.endswith("ground")
    }


@pytest.mark.parametrize("settings", SMALL)
def test_buildings_are_closed_but_for_their_bottoms(settings: TownSettings) -> None:
    scene = make_town(settings)
    terrain = make_plan(settings).terrain
    on_ground = np.array([x % UNIT == 0 and z == terrain.height(int(x)) for x, _, z in scene.vertices])
    for name, faces in buildings(scene).items():
        keys, uses = np.unique(edge_keys(faces), return_counts=True)
        assert uses.max() == 2, name
        open_edges = keys[uses == 1]
        assert len(open_edges) >= 4
        assert on_ground[open_edges >> 32].all(), name
        assert on_ground[open_edges & 0xFFFFFFFF].all(), name
        directed = (faces << 32) | np.roll(faces, -1, axis=1)
        assert len(np.unique(directed)) == directed.size, name  # neighbours are oriented alike


@pytest.mark.parametrize("settings", [SMALL[0], SMALL[4]])
def test_buildings_are_seen_from_outside(settings: TownSettings) -> None:
    """On level ground at z = 0 the open bottoms add nothing to the volume."""
    scene = make_town(settings)
    for name, faces in buildings(scene).items():
        volume = np.linalg.det(scene.vertices[faces] / METRE).sum() / 6
        assert volume > 20, name


@pytest.mark.parametrize("settings", SMALL)
def test_town_is_noded_and_has_no_face_without_area(settings: TownSettings) -> None:
    scene = make_town(settings)
    assert count_junctions(scene.vertices, scene.faces.astype(np.int64)) == 0
    assert has_area(scene.corners()).all()
    assert len(np.unique(scene.vertices, axis=0)) == len(scene.vertices)
    assert len(np.unique(np.sort(scene.faces, axis=1), axis=0)) == scene.face_count


@pytest.mark.parametrize("seed", range(6))
def test_footprints_are_apart(seed: int) -> None:
    plan = make_plan(TownSettings(seed=seed, width=100, depth=100))
    footprints = [b.footprint for block in plan.blocks for b in block.buildings]
    kinds = {b.kind for block in plan.blocks for b in block.buildings}
    assert kinds == {"house", "courtyard", "arcade", "tower"}
    for a, b in itertools.combinations(footprints, 2):
        gaps = (b[0] - a[2], a[0] - b[2], b[1] - a[3], a[1] - b[3])
        assert max(gaps) >= METRE
    for x0, y0, x1, y1 in footprints:
        assert min(x1 - x0, y1 - y0) >= 5 * METRE
        assert all(c % UNIT == 0 for c in (x0, y0, x1, y1))


@pytest.mark.jit
def test_sizes_are_those_of_the_training_site() -> None:
    scene = make_town(TRAINING_SITE)
    assert 60_000 <= scene.face_count <= 80_000
    assert 25_000 <= len(scene.vertices) <= 35_000
    ground = [k for k, name in enumerate(scene.object_names) if name.split("/")[0].endswith("ground")]
    corners = scene.corners()[np.isin(scene.face_object, ground)] / METRE
    area = (
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        / 2
    )
    assert area == pytest.approx(10_000)
    per_building = np.mean([len(f) for f in buildings(scene).values()])
    assert 800 <= per_building <= 1200


@pytest.mark.jit
@pytest.mark.parametrize(("detail", "least", "most"), [("coarse", 40, 75), ("median", 200, 320)])
def test_detail_sets_the_faces_of_a_building(detail: str, least: int, most: int) -> None:
    scene = make_town(TownSettings(detail=detail, width=100, depth=100))
    assert least <= np.mean([len(f) for f in buildings(scene).values()]) <= most


def test_default_is_small_and_has_every_kind() -> None:
    scene = make_town()
    assert 1000 <= scene.face_count <= 5000
    names = " ".join(scene.object_names)
    assert all(kind in names for kind in ("house", "courtyard", "arcade", "tower", "ground"))


def test_seed_decides_the_town() -> None:
    first, again, other = (make_town(TownSettings(seed=s)) for s in (4, 4, 5))
    assert np.array_equal(first.vertices, again.vertices)
    assert np.array_equal(first.faces, again.faces)
    assert first.object_names == again.object_names
    assert not np.array_equal(first.vertices, other.vertices)


def test_slope_keeps_the_plan() -> None:
    flat, sloped = (make_plan(TownSettings(sloped=s, width=100)) for s in (False, True))
    assert flat.blocks == sloped.blocks
    heights = [sloped.terrain.height(x) for x in sloped.terrain.knots]
    assert max(heights) - min(heights) > METRE


def crosses(scene, start: np.ndarray, end: np.ndarray) -> int:
    """Number of faces that a segment in general position crosses; exact integers."""
    corners = scene.corners().astype(object)
    origin = corners[:, 0]
    normal = np.cross((corners[:, 1] - origin).astype(object), (corners[:, 2] - origin).astype(object))
    first = ((start - origin) * normal).sum(axis=1)
    last = ((end - origin) * normal).sum(axis=1)
    assert (first != 0).all()
    assert (last != 0).all()
    count = 0
    for face in np.flatnonzero((first > 0) != (last > 0)):
        a, b, c = corners[face]
        sides = [np.dot(np.cross(p - start, q - start), end - start) for p, q in ((a, b), (b, c), (c, a))]
        assert all(sides)
        count += all(s > 0 for s in sides) or all(s < 0 for s in sides)
    return count


@pytest.mark.parametrize("detail", ["coarse", pytest.param("fine", marks=pytest.mark.jit)])
def test_arcade_can_be_flown_through_and_houses_are_blocked(detail: str) -> None:
    settings = TownSettings(detail=detail)
    scene = make_town(settings)
    (arcade,) = (b for block in make_plan(settings).blocks for b in block.buildings if b.kind == "arcade")
    x0, y0, x1, y1 = arcade.footprint
    bay = (x1 - x0) // ((x1 - x0) // (4 * METRE))
    height = METRE * 3 // 2 + 5
    for at, faces in ((bay // 2 + 7, 0), (387, 2)):  # first passage; its outer pier
        start = np.array((x0 + at, y0 - METRE - 3, height), object)
        end = np.array((x0 + at + 2, y1 + METRE + 1, height + 3), object)
        assert crosses(scene, start, end) == faces


@pytest.mark.parametrize(
    ("name", "value"), [("detail", "superb"), ("seed", -1), ("width", 30), ("depth", 0), ("width", 1025)]
)
def test_bad_setting_is_named(name: str, value: object) -> None:
    with pytest.raises(SceneError) as caught:
        TownSettings(**{name: value})  # type: ignore[arg-type]
    assert caught.value.place == name


def test_terrain_is_on_the_grid_or_refuses() -> None:
    terrain = Terrain((0, 640, 1280), (3, -2))
    assert [terrain.height(x) for x in (0, 64, 640, 704, 1280)] == [0, 3, 30, 28, 10]
    with pytest.raises(ValueError, match="not a multiple"):
        terrain.height(65)

"""Units, axes, origin, coordinate systems, parts and regions of scene input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tilesnav_ref.scene import SceneError, SceneSettings, load_scene, write_mesh
from tilesnav_ref.scene.analytic import SCENES
from tilesnav_ref.scene.frame import ecef_from_enu
from tilesnav_ref.scene.weld import snap

STEPS = 1024


def save(path: Path, mesh: trimesh.Trimesh | trimesh.Scene) -> Path:
    exported = mesh.export(file_type=path.suffix[1:])
    path.write_bytes(exported.encode() if isinstance(exported, str) else exported)
    return path


def box(size: tuple[float, float, float], at: tuple[float, float, float] = (0, 0, 0)) -> trimesh.Trimesh:
    """A box with its least corner at a place."""
    mesh = trimesh.creation.box(size)
    mesh.apply_translation(np.array(size) / 2 + at)
    return mesh


def extent(scene) -> tuple[list[float], list[float]]:
    return (scene.vertices.min(axis=0) / STEPS).tolist(), (scene.vertices.max(axis=0) / STEPS).tolist()


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".off"])
def test_formats_without_an_axis_are_taken_as_they_are(tmp_path: Path, suffix: str) -> None:
    scene, report = load_scene(save(tmp_path / f"box{suffix}", box((1, 2, 3))))
    assert extent(scene) == ([0, 0, 0], [1, 2, 3])
    assert (report.up, report.faces, report.vertices, report.moved_max) == ("z", 12, 8, 0.0)
    assert (report.boundary_edges, report.non_manifold_edges, report.doubled_faces) == (0, 0, 0)


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_gltf_is_y_up_by_definition(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"box{suffix}"
    if suffix == ".glb":
        save(path, box((1, 2, 3)))
    else:
        for name, data in trimesh.Scene([box((1, 2, 3))]).export(file_type="gltf").items():
            (tmp_path / name.replace("model.gltf", path.name)).write_bytes(data)
    scene, report = load_scene(path)
    assert report.up == "y"
    assert extent(scene) == ([0, -3, 0], [1, 0, 2])
    upright, report = load_scene(path, SceneSettings(up="z"))
    assert report.up == "z"
    assert extent(upright) == ([0, 0, 0], [1, 2, 3])


def test_axes_keep_the_orientation_of_faces(tmp_path: Path) -> None:
    path = save(tmp_path / "box.ply", box((1, 2, 3)))
    for up, upper in (("z", [1, 2, 3]), ("y", [1, 0, 2]), ("x", [2, 3, 1])):
        scene, _ = load_scene(path, SceneSettings(up=up))
        assert extent(scene)[1] == upper
        volume = np.linalg.det(scene.corners().astype(float)).sum() / 6 / STEPS**3
        assert volume == pytest.approx(6)


@pytest.mark.parametrize(
    ("units", "metres"),
    [
        ("m", 1.0),
        ("cm", 0.01),
        ("mm", 0.001),
        ("km", 1000.0),
        ("in", 0.0254),
        ("ft", 0.3048),
        ("us-ft", 0.3048006096),
    ],
)
def test_units_become_metres(tmp_path: Path, units: str, metres: float) -> None:
    path = save(tmp_path / "box.ply", box((4, 4, 4)))
    scene, report = load_scene(path, SceneSettings(units=units))
    assert scene.vertices.max() == round(4 * metres * STEPS)
    assert report.metres_per_unit == pytest.approx(metres, rel=1e-9)
    assert report.moved_max <= np.sqrt(3) / 2 / STEPS


def test_origin_is_subtracted_before_snapping(tmp_path: Path) -> None:
    path = tmp_path / "far.obj"
    path.write_text(
        "v 690000.125 5336000.25 500\nv 690001.125 5336000.25 500\nv 690000.125 5336001.25 500\nf 1 2 3\n"
    )
    scene, report = load_scene(path, SceneSettings(origin=(690000.0, 5336000.0, 500.0)))
    assert extent(scene) == ([0.125, 0.25, 0], [1.125, 1.25, 0])
    assert report.moved_max == 0.0
    assert np.array_equal(scene.tileset_from_nav, np.eye(4))


def test_enu_places_the_nav_frame_on_the_ellipsoid(tmp_path: Path) -> None:
    path = save(tmp_path / "box.ply", box((1, 2, 3)))
    scene, _ = load_scene(path, SceneSettings(crs="enu", origin=(0.0, 0.0, 10.0)))
    assert extent(scene) == ([0, 0, 0], [1, 2, 3])
    expected = [[0, 0, 1, 6378147.0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]
    assert np.allclose(scene.tileset_from_nav, expected, atol=1e-9)


def test_pole_and_a_published_point_have_their_earth_centred_coordinates() -> None:
    assert np.allclose(ecef_from_enu((0.0, 90.0, 0.0))[:3, 3], [0, 0, 6356752.314245], atol=1e-6)
    # 45 north, 90 east: N = a / sqrt(1 - e2 / 2), worked by hand
    assert np.allclose(ecef_from_enu((90.0, 45.0, 0.0))[:3, 3], [0, 4517590.8788, 4487348.4089], atol=1e-3)
    matrix = ecef_from_enu((11.5, 48.1, 520.0))[:3, :3]
    assert np.allclose(matrix.T @ matrix, np.eye(3), atol=1e-15)
    assert np.linalg.det(matrix) == pytest.approx(1)


def test_earth_centred_file_gets_a_local_frame(tmp_path: Path) -> None:
    frame = ecef_from_enu((11.5, 48.1, 520.0))
    local = np.array([(0, 0, 0), (10, 0, 0), (0, 8, 0), (0, 0, 4)], float)
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in local @ frame[:3, :3].T + frame[:3, 3]]
    path = tmp_path / "earth.obj"
    path.write_text("\n".join([*lines, "f 1 2 3", "f 1 3 4", "f 1 4 2"]))
    given, _ = load_scene(path, SceneSettings(crs="EPSG:4978", origin=(11.5, 48.1, 520.0)))
    assert extent(given) == ([0, 0, 0], [10, 8, 4])
    found, report = load_scene(path, SceneSettings(crs="EPSG:4978"))
    assert "nav frame" in report.notes[0]
    back = found.vertices / STEPS @ found.tileset_from_nav[:3, :3].T + found.tileset_from_nav[:3, 3]
    wanted = local @ frame[:3, :3].T + frame[:3, 3]
    assert max(np.linalg.norm(wanted - p, axis=1).min() for p in back) < 2 / STEPS
    assert abs(found.vertices[:, 2].min()) <= 2


def test_coordinate_system_without_pyproj_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyproj", None)
    path = save(tmp_path / "box.ply", box((1, 1, 1)))
    with pytest.raises(SceneError, match=r"tilesnav\[crs\]"):
        load_scene(path, SceneSettings(crs="EPSG:25832"))


def test_nodes_are_placed_and_points_left_out(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(box((1, 1, 1)), node_name="first", geom_name="box")
    scene.graph.update("second", geometry="box", matrix=trimesh.transformations.translation_matrix((5, 0, 0)))
    scene.add_geometry(trimesh.PointCloud(np.zeros((4, 3))), node_name="points", geom_name="points")
    path = save(tmp_path / "two.glb", scene)
    loaded, report = load_scene(path, SceneSettings(object_faces_min=1))
    assert (report.parts, report.faces, report.objects) == (2, 24, 2)
    assert loaded.object_names == ("first", "second")
    assert extent(loaded)[1] == [6, 0, 1]
    assert report.notes == ("1 sets of points or lines were left out",)


def test_damaged_encoding_of_a_name_does_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "named.obj"
    path.write_bytes("o h\xe4user\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".encode("latin-1"))
    assert load_scene(path)[0].face_count == 1


def test_back_references_of_obj_are_read(tmp_path: Path) -> None:
    path = tmp_path / "back.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 9 9 9\nv 8 9 9\nv 9 8 9\nf 4 5 6\n")
    assert load_scene(path)[0].face_count == 2


def town_of_two(tmp_path: Path) -> Path:
    """A large ground of 4 x 4 squares of 25 m and two houses above it."""
    ground = [
        trimesh.Trimesh(
            [(x, y, 0), (x + 25, y, 0), (x + 25, y + 25, 0), (x, y + 25, 0)],
            [(0, 1, 2), (0, 2, 3)],
            process=False,
        )
        for x in range(0, 100, 25)
        for y in range(0, 100, 25)
    ]
    houses = [box((8, 8, 5), (9, 9, 1)), box((8, 8, 5), (80, 80, 1))]
    return save(tmp_path / "town.ply", trimesh.util.concatenate([*ground, *houses]))


def test_region_keeps_whole_houses_and_cuts_the_ground(tmp_path: Path) -> None:
    path = town_of_two(tmp_path)
    scene, report = load_scene(path, SceneSettings(region=(1, 1, 10, 10), region_margin=1))
    assert (report.cropped_faces, report.cut_components) == (12 + 30, 1)
    assert report.faces == 12 + 2
    assert "1 of 2 components are larger than the region" in report.notes[0]
    assert extent(scene) == ([0, 0, 0], [25, 25, 6])
    scene, report = load_scene(path, SceneSettings(region=(1, 1, 10, 10), region_margin=20.5))
    assert report.faces == 12 + 8


def test_region_without_faces_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="no face in"):
        load_scene(town_of_two(tmp_path), SceneSettings(region=(500, 500, 510, 510)))


def test_region_brings_a_wide_scene_within_the_grid(tmp_path: Path) -> None:
    path = save(
        tmp_path / "wide.ply", trimesh.util.concatenate([box((1, 1, 1)), box((1, 1, 1), (20000, 0, 0))])
    )
    with pytest.raises(SceneError, match="2\\^23"):
        load_scene(path)
    assert load_scene(path, SceneSettings(region=(0, 0, 5, 5)))[1].faces == 12
    assert load_scene(path, SceneSettings(grid_exponent=-8))[1].faces == 24


def test_report_counts_what_is_not_clean(tmp_path: Path) -> None:
    path = tmp_path / "odd.obj"
    vertices = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 2 0 0\nv 2 -2 0\nv 0.0001 0 0\nv 4 0 0\n"
    faces = "f 1 2 3\nf 2 3 1\nf 4 5 2\nf 1 6 5\n"
    path.write_text(vertices + faces)
    scene, report = load_scene(path)
    assert report.file_faces == 4
    assert report.degenerate_removed == 1
    assert report.vertices_merged == 1  # the sixth falls on the first; the seventh is not used
    assert report.junctions == 1
    assert (report.faces_before_noding, report.faces_divided, report.faces) == (3, 2, 5)
    assert report.doubled_faces == 2
    assert report.moved_max == pytest.approx(0.0001)
    assert report.components == 1
    assert json.loads(json.dumps(report.as_dict()))["faces"] == scene.face_count
    assert set(report.seconds) == {"read", "snap", "crop", "build"}


def test_noding_can_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "odd.obj"
    path.write_text("v 0 0 0\nv 4 0 0\nv 0 4 0\nv 2 0 0\nv 2 -2 0\nf 1 2 3\nf 4 5 2\n")
    _, report = load_scene(path, SceneSettings(node_junctions=False))
    assert (report.junctions, report.faces_divided, report.faces) == (1, 0, 2)


def test_halves_are_rounded_to_even() -> None:
    values = np.array([[0.5, 1.5, -0.5], [-1.5, 2.5, 2.75]]) / STEPS
    assert snap(values, -10, "x").tolist() == [[0, 2, 0], [-2, 2, 3]]


@pytest.mark.parametrize("suffix", [".ply", ".glb"])
def test_written_mesh_reads_back_exactly(tmp_path: Path, suffix: str) -> None:
    scene = SCENES["l_corridor"]().scene
    path = tmp_path / f"written{suffix}"
    write_mesh(scene, path)
    again, report = load_scene(path)
    assert report.moved_max == 0.0
    assert sorted(again.corners().reshape(-1, 9).tolist()) == sorted(scene.corners().reshape(-1, 9).tolist())
    assert list(tmp_path.iterdir()) == [path]


def test_writer_refuses_what_it_cannot_do(tmp_path: Path) -> None:
    scene = SCENES["one_wall"]().scene
    with pytest.raises(SceneError, match=r"\.ply or \.glb"):
        write_mesh(scene, tmp_path / "scene.stl")
    with pytest.raises(SceneError, match="No such file"):
        write_mesh(scene, tmp_path / "absent" / "scene.ply")


def test_projected_coordinates_keep_their_place(tmp_path: Path) -> None:
    pyproj = pytest.importorskip("pyproj", reason="the optional package pyproj is not installed")
    path = tmp_path / "utm.obj"
    corners = [(691600, 5334760, 520), (691610, 5334760, 520), (691600, 5334770, 520), (691600, 5334760, 530)]
    path.write_text("\n".join([*(f"v {x} {y} {z}" for x, y, z in corners), "f 1 2 3", "f 1 2 4"]))
    scene, report = load_scene(path, SceneSettings(crs="EPSG:25832"))
    assert report.notes
    earth = scene.vertices / STEPS @ scene.tileset_from_nav[:3, :3].T + scene.tileset_from_nav[:3, 3]
    back = pyproj.Transformer.from_crs("EPSG:4978", "EPSG:25832", always_xy=True).transform(*earth.T)
    assert np.allclose(
        sorted(zip(back[0], back[1], strict=True)), sorted(c[:2] for c in corners), atol=1 / STEPS
    )
    with pytest.raises(SceneError, match="EPSG:999999"):
        load_scene(path, SceneSettings(crs="EPSG:999999"))

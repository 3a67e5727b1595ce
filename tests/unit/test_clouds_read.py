"""Readers of point clouds, each with files written from the definition of its format."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from cloud_files import INTENSITIES, POINTS, lzf_literals, pcd_bytes, pcd_header, ply_bytes, write_las

from tilesnav_ref.clouds import CloudSettings, PointCloud, cloud_chunks, las, read_cloud
from tilesnav_ref.clouds.lzf import expand
from tilesnav_ref.scene import SceneError

AUTZEN = Path(__file__).resolve().parents[3] / "shared/data/autzen_north_lidar/autzen_north.laz"
FAR = np.array((650000.0, 5_000_000.0, 100.0))
FEET = (
    'PROJCS["made up",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],'
    'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["foot",0.3048]]'
)


def absolute(cloud: PointCloud) -> np.ndarray:
    return cloud.points + cloud.origin


def write(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


FILES = {
    "a.ply": ply_bytes("ascii"),
    "b.ply": ply_bytes("binary_little_endian"),
    "c.ply": ply_bytes("binary_big_endian"),
    "a.pcd": pcd_bytes("ascii"),
    "b.pcd": pcd_bytes("binary"),
    "c.pcd": pcd_bytes("binary_compressed"),
    "a.xyz": b"# made by hand\n1.5 2.25 3 1\n-4 5.5 0.125 20\n\n7 -8 9.75 300\n.5 .25 -1 4\n",
    "a.csv": b"X,Y,Z,Intensity\r\n1.5,2.25,3,1\r\n-4,5.5,0.125,20\r\n7,-8,9.75,300\r\n0.5,0.25,-1,4",
    "b.csv": b"intensity;z;y;x\n1;3;2.25;1.5\n20;0.125;5.5;-4\n300;9.75;-8;7\n4;-1;.25;.5\n",
}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("size", [1, 3, 1000])
def test_formats(name: str, size: int, tmp_path: Path) -> None:
    cloud = read_cloud(write(tmp_path / name, FILES[name]), CloudSettings(chunk_points=size))
    assert np.array_equal(absolute(cloud), POINTS)
    assert cloud.intensities is not None
    assert np.array_equal(cloud.intensities, INTENSITIES)
    assert (np.mod(cloud.origin, 100.0) == 0).all()
    assert cloud.classes is None


def test_the_scanner_of_a_pcd_file(tmp_path: Path) -> None:
    cloud = read_cloud(write(tmp_path / "a.pcd", FILES["a.pcd"]))
    assert cloud.scan_origins is not None
    assert (cloud.scan_origins + cloud.origin).tolist() == [[10, 20, 30]]
    assert cloud.scans is not None
    assert cloud.scans.tolist() == [0, 0, 0, 0]


def test_elements_before_the_vertices_are_passed_over(tmp_path: Path) -> None:
    extra = "element camera 2\nproperty uchar a\nproperty double b\n"
    data = ply_bytes("binary_little_endian", extra=extra)
    head, rows = data.split(b"end_header\n")
    cloud = read_cloud(write(tmp_path / "a.ply", head + b"end_header\n" + bytes(18) + rows))
    assert np.array_equal(absolute(cloud), POINTS)


@pytest.mark.parametrize("ending", ["las", "laz"])
def test_las(ending: str, tmp_path: Path) -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")
    path = tmp_path / f"a.{ending}"
    write_las(path, POINTS + FAR)
    cloud = read_cloud(path)
    assert cloud.origin.tolist() == [649900.0, 5_000_000.0 - 100.0 * (POINTS[:3, 1].min() < 0), 100.0]
    assert np.allclose(absolute(cloud), POINTS[:3] + FAR, atol=1e-6)
    assert cloud.classes is not None
    assert cloud.classes.tolist() == [2, 2, 2]
    assert cloud.return_counts is not None
    assert cloud.return_counts.tolist() == [2, 2, 2]
    assert "3 of 4 points kept" in cloud.notes
    noise = read_cloud(path, CloudSettings(classes=(7,)))
    assert np.allclose(absolute(noise), POINTS[3:] + FAR, atol=1e-6)


def test_lack_of_memory_is_not_the_file_s_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")
    write_las(tmp_path / "a.las", POINTS)

    def short_of_memory(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(las, "_chunk", short_of_memory)
    with pytest.raises(MemoryError):
        read_cloud(tmp_path / "a.las", CloudSettings(units="m"))


def test_feet_from_the_coordinate_system(tmp_path: Path) -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")
    pytest.importorskip("pyproj", reason="coordinate systems are an extra")
    path = tmp_path / "a.las"
    write_las(path, POINTS + 1000.0, FEET)
    cloud = read_cloud(path)
    assert cloud.metres_per_unit == 0.3048
    assert np.allclose(absolute(cloud), (POINTS[:3] + 1000.0) * 0.3048, atol=1e-6)
    assert "heights taken to be in the unit of the map: foot" in cloud.notes
    assert read_cloud(path, CloudSettings(units="m")).metres_per_unit == 1.0


def test_an_unread_coordinate_system_asks_for_units(tmp_path: Path) -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")
    path = tmp_path / "a.las"
    write_las(path, POINTS, "no such thing")
    with pytest.raises(SceneError, match="--units"):
        read_cloud(path)
    assert read_cloud(path, CloudSettings(units="ft")).metres_per_unit == 0.3048


def test_degrees_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")
    pyproj = pytest.importorskip("pyproj", reason="coordinate systems are an extra")
    path = tmp_path / "a.las"
    write_las(path, POINTS, pyproj.CRS("EPSG:4326").to_wkt("WKT1_GDAL"))
    with pytest.raises(SceneError, match="in degrees"):
        read_cloud(path)


def test_e57(tmp_path: Path) -> None:
    pye57 = pytest.importorskip("pye57", reason="E57 is an extra")
    path = tmp_path / "a.e57"
    quarter = np.array((np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)))  # about z
    with pye57.E57(str(path), mode="w") as file:
        for number in range(2):
            columns = dict(zip(("cartesianX", "cartesianY", "cartesianZ"), POINTS.T.copy(), strict=True))
            columns["intensity"] = INTENSITIES.copy()
            file.write_scan_raw(columns, rotation=quarter, translation=np.array((100.0 * number, 0.0, 5.0)))
    cloud = read_cloud(path, CloudSettings(chunk_points=3))
    turned = np.stack((-POINTS[:, 1], POINTS[:, 0], POINTS[:, 2] + 5.0), axis=1)
    assert np.allclose(absolute(cloud), np.concatenate((turned, turned + np.array((100.0, 0.0, 0.0)))))
    assert cloud.scan_origins is not None
    assert np.allclose(cloud.scan_origins + cloud.origin, [(0, 0, 5), (100, 0, 5)])
    assert cloud.scans is not None
    assert cloud.scans.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]


def test_units_and_region(tmp_path: Path) -> None:
    path = write(tmp_path / "a.xyz", FILES["a.xyz"])
    feet = read_cloud(path, CloudSettings(units="ft"))
    assert np.allclose(absolute(feet), POINTS * 0.3048)
    part = read_cloud(path, CloudSettings(region=(0.0, 0.0, 2.0, 3.0)))
    assert np.array_equal(absolute(part), POINTS[[0, 3]])


def test_thinning_keeps_the_first_point_of_each_cube(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    points = random.uniform(0.0, 10.0, (5000, 3)).round(3)
    path = tmp_path / "a.xyz"
    np.savetxt(path, points, fmt="%.3f")
    thin = read_cloud(path, CloudSettings(thin=2.0, chunk_points=700))
    _, first = np.unique(np.floor(points / 2.0), axis=0, return_index=True)
    assert np.allclose(absolute(thin), points[np.sort(first)])


def test_points_without_a_place_are_left_out(tmp_path: Path) -> None:
    path = write(tmp_path / "a.xyz", b"1 2 3\nnan nan nan\n4 5 inf\n6 7 8\n")
    assert absolute(read_cloud(path)).tolist() == [[1, 2, 3], [6, 7, 8]]


def test_chunks_are_bounded(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    random = np.random.default_rng(0).normal(size=(1000, 3))
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 1000\n"
    head += b"property float x\nproperty float y\nproperty float z\nend_header\n"
    path.write_bytes(head + random.astype("<f4").tobytes())
    sizes = [len(chunk.points) for chunk, _, _ in cloud_chunks(path, CloudSettings(chunk_points=300))]
    assert sizes == [300, 300, 300, 100]


PLY = ply_bytes("binary_little_endian")
LONG = lzf_literals(bytes(112))
BAD = {
    "no ending": ("a", b"1 2 3\n", "name"),
    "no file": ("a.ply", None, "file"),
    "empty ply": ("a.ply", b"", "header"),
    "ply without end": ("a.ply", b"ply\nformat ascii 1.0\n", "header"),
    "ply cut": ("a.ply", PLY[:-5], "length"),
    "ply claims": ("a.ply", ply_bytes("binary_little_endian", 10**9), "length"),
    "ply negative": ("a.ply", ply_bytes("binary_little_endian", -1), "header"),
    "ply type": ("a.ply", PLY.replace(b"double x", b"quad x"), "header"),
    "ply list": ("a.ply", PLY.replace(b"property double x", b"property list uchar int x"), "header"),
    "ply twice": ("a.ply", PLY.replace(b"double y", b"double x"), "header"),
    "ply no vertex": ("a.ply", PLY.replace(b"vertex", b"corner"), "header"),
    "ply rows": ("a.ply", ply_bytes("ascii", 9), "points"),
    "ply words": ("a.ply", ply_bytes("ascii").replace(b"-8.0", b"x"), "point 2"),
    "pcd count": ("a.pcd", pcd_header("binary", 10**9) + bytes(100), "length"),
    "pcd kind": ("a.pcd", pcd_header("magic"), "header"),
    "pcd size": ("a.pcd", pcd_bytes("binary").replace(b"SIZE 8", b"SIZE 3"), "header"),
    "pcd width": ("a.pcd", pcd_bytes("binary").replace(b"WIDTH 4", b"WIDTH 5"), "header"),
    "pcd fields": ("a.pcd", pcd_bytes("binary").replace(b"FIELDS x", b"FIELDS a"), "header"),
    "pcd no fields": ("a.pcd", pcd_bytes("binary").replace(b"FIELDS", b"FELDS"), "header"),
    "pcd raw": ("a.pcd", pcd_header("binary_compressed") + struct.pack("<II", 9, 2**32 - 1), "compressed"),
    "pcd packed": ("a.pcd", pcd_header("binary_compressed") + struct.pack("<II", 2**31, 112), "compressed"),
    "pcd block": (
        "a.pcd",
        pcd_header("binary_compressed") + struct.pack("<II", 4, 112) + b"\xff\xff\xff\xff",
        "compressed",
    ),
    "pcd short": (
        "a.pcd",
        pcd_header("binary_compressed") + struct.pack("<II", len(LONG) - 9, 112) + LONG[:-9],
        "compressed",
    ),
    "xyz words": ("a.xyz", b"1 2 3\n4 5 six\n", "point 1"),
    "xyz two": ("a.xyz", b"1 2\n", "first row"),
    "xyz ragged": ("a.xyz", b"1 2 3\n4 5 6 7\n", "point 1"),
    "xyz one line": ("a.xyz", b"1" * 10000, "first row"),
    "xyz empty": ("a.xyz", b"", "first row"),
    "xyz binary": ("a.xyz", bytes(range(256)) * 40, "first row"),
    "xyz nan": ("a.xyz", b"nan nan nan\n", "points"),
    "xyz far": ("a.xyz", b"1 2 3e12\n", "points"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files(case: str, tmp_path: Path) -> None:
    name, data, place = BAD[case]
    path = tmp_path / name
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(SceneError) as caught:
        read_cloud(path)
    assert caught.value.source == str(path)
    assert place in caught.value.place


def test_bad_las(tmp_path: Path) -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")
    las, laz = tmp_path / "a.las", tmp_path / "a.laz"
    points = np.random.default_rng(1).uniform(0, 50, (2000, 3))
    write_las(las, points)
    write_las(laz, points)
    for path in (las, laz):
        whole = path.read_bytes()
        for length in (0, 10, 200, len(whole) // 2, len(whole) - 7):
            path.write_bytes(whole[:length])
            with pytest.raises(SceneError):
                read_cloud(path)


def test_bad_e57(tmp_path: Path) -> None:
    pytest.importorskip("pye57", reason="E57 is an extra")
    path = write(tmp_path / "a.e57", b"ASTM-E57" + bytes(100))
    with pytest.raises(SceneError, match="header"):
        read_cloud(path)
    assert path.exists()


def test_too_many_points(tmp_path: Path) -> None:
    path = write(tmp_path / "a.xyz", FILES["a.xyz"])
    with pytest.raises(SceneError, match="--thin"):
        read_cloud(path, CloudSettings(max_points=3))


@pytest.mark.parametrize(
    "settings",
    [
        {"units": "mile"},
        {"classes": (256,)},
        {"thin": -1.0},
        {"region": (1.0, 0.0, 0.0, 1.0)},
        {"max_points": 0},
        {"chunk_points": 0},
    ],
)
def test_bad_settings(settings: dict) -> None:
    with pytest.raises(SceneError, match=next(iter(settings))):
        CloudSettings(**settings)


def test_lzf_copies_and_refusals() -> None:
    # literals "abc", a copy of 3 from 3 back, a copy of 9 from 1 back (length 7 and one more)
    block = np.frombuffer(bytes([2, *b"abc", 0b00100000, 2, 0b11100000, 0, 0]), np.uint8)
    out = np.zeros(15, np.uint8)
    assert expand(block, out) == 15
    assert out.tobytes() == b"abcabccccccccccc"[:15]
    for cut in range(1, len(block)):
        assert expand(block[:cut], np.zeros(15, np.uint8)) != 15
    assert expand(block, np.zeros(14, np.uint8)) == -1
    assert expand(np.frombuffer(bytes([0b00100000, 0]), np.uint8), np.zeros(9, np.uint8)) == -1


@pytest.mark.realdata
@pytest.mark.skipif(not AUTZEN.exists(), reason="no shared/data beside the checkout")
def test_autzen_is_in_feet() -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")
    pytest.importorskip("pyproj", reason="coordinate systems are an extra")
    cloud = read_cloud(AUTZEN, CloudSettings(thin=2.0))
    assert cloud.metres_per_unit == 0.3048
    size = np.ptp(cloud.points, axis=0)
    assert np.allclose(size, (1010.1, 300.0, 44.1), atol=0.5)  # as the README of the data says

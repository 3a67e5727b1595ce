"""Bounding volumes of tiles and sectors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tilesnav_validator import volumes

EYE = np.eye(4)


def test_box_sides() -> None:
    box = np.array([1, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1], dtype=float)
    assert volumes.box_excess(box, np.array([[3.0, 1, 1]])) == 0
    assert volumes.box_excess(box, np.array([[3.25, 0, 0], [0, 0, 0]])) == 0.25
    assert volumes.box_excess(box, np.array([[-1.5, 0, 0]])) == 0.5
    assert volumes.box_excess(box, np.zeros((0, 3))) == -math.inf


def test_turned_and_flat_boxes() -> None:
    turned = np.array([0, 0, 0, 1, 1, 0, -1, 1, 0, 0, 0, 1], dtype=float)
    assert volumes.box_excess(turned, np.array([[0.0, 2, 0]])) == pytest.approx(0)
    assert volumes.box_excess(turned, np.array([[2.0, 2, 0]])) == pytest.approx(math.sqrt(2))
    flat = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0], dtype=float)
    assert volumes.box_excess(flat, np.array([[1.0, 1, 0]])) == 0
    assert volumes.box_excess(flat, np.array([[0.0, 0, 0.5]])) == 0.5
    line = np.array([0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0], dtype=float)
    assert volumes.box_excess(line, np.array([[1.0, 0, 0]])) == 0
    assert volumes.box_excess(line, np.array([[0.0, 0, 0.5]])) == 0.5
    point = np.zeros(12)
    assert volumes.box_excess(point, np.zeros((1, 3))) == 0
    assert volumes.box_excess(point, np.array([[0.0, 0, 0.5]])) == 0.5


def test_sphere() -> None:
    assert volumes.sphere_excess(np.array([1.0, 0, 0, 2]), np.array([[4.0, 0, 0], [1, 0, 0]])) == 1


def ecef(longitude: float, latitude: float, height: float) -> list[float]:
    """Forward formula of WGS84, for a check of the inverse."""
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)
    n = a / math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    around = (n + height) * math.cos(latitude)
    return [
        around * math.cos(longitude),
        around * math.sin(longitude),
        (n * (1 - e2) + height) * math.sin(latitude),
    ]


@pytest.mark.parametrize("height", [-10_000.0, 0.0, 100.0, 1e6])
def test_geodetic_coordinates_there_and_back(height: float) -> None:
    places = [(lon, lat) for lon in (-3.1, -1.0, 0.0, 2.5) for lat in (-math.pi / 2, -1.2, 0.0, 0.7, 1.5707)]
    found = volumes.geodetic(np.array([ecef(lon, lat, height) for lon, lat in places]))
    for (lon, lat), row in zip(places, found, strict=True):
        assert row[1] == pytest.approx(lat, abs=1e-14)
        assert row[2] == pytest.approx(height, abs=1e-8)
        if abs(lat) < 1.57:
            assert row[0] == pytest.approx(lon, abs=1e-14)


def test_region_and_the_date_line() -> None:
    region = np.array([3.1, 0.5, -3.1, 0.6, 0, 100])
    inside = np.array([ecef(3.13, 0.55, 50), ecef(-3.13, 0.55, 0)])
    assert volumes.region_excess(region, inside) <= 0
    metre = 1 / 6378137.0
    assert volumes.region_excess(region, np.array([ecef(3.13, 0.6 + metre, 50)])) == pytest.approx(
        1, rel=1e-3
    )
    assert volumes.region_excess(region, np.array([ecef(3.13, 0.55, 102)])) == pytest.approx(2, abs=1e-6)
    assert volumes.region_excess(region, np.array([ecef(3.13, 0.55, -3)])) == pytest.approx(3, abs=1e-6)
    beside = volumes.region_excess(region, np.array([ecef(3.1 - metre, 0.55, 50)]))
    assert beside == pytest.approx(math.cos(0.55), rel=1e-3)
    whole = np.array([-math.pi, -2, math.pi, 2, -1e9, 1e9])
    assert volumes.region_excess(whole, np.array([ecef(math.pi, 0, 0), ecef(1, 1, 1)])) <= 0
    assert volumes.region_excess(region, np.zeros((0, 3))) == -math.inf


MALFORMED: list[Any] = [
    None,
    [],
    {},
    {"box": [0] * 11},
    {"box": "x"},
    {"sphere": [0, 0, 0, math.inf]},
    {"region": [[0]] * 6},
    {"box": [[0, 1], 2]},
]


@pytest.mark.parametrize("volume", MALFORMED)
def test_malformed_volumes_are_faults(volume: Any) -> None:
    fault = volumes.fault(volume, np.zeros((1, 3)), EYE, 0.0)
    assert fault is not None
    assert "malformed" in fault or "no box" in fault


def test_region_is_measured_in_the_frame_of_the_root() -> None:
    to_root = np.eye(4)
    to_root[:3, 3] = ecef(0.2, 0.5, 10)
    tight = {"region": [0.2, 0.5, 0.2, 0.5, 9, 11]}
    assert volumes.fault(tight, np.zeros((1, 3)), to_root, 1e-6) is None
    assert volumes.fault(tight, np.array([[5.0, 0, 0]]), to_root, 1e-6) is not None


def test_allowance() -> None:
    volume = {"sphere": [0, 0, 0, 1], "box": [0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2]}
    point = np.array([[1.25, 0, 0]])
    assert volumes.fault(volume, point, EYE, 0.25) is None
    assert volumes.fault(volume, point, EYE, 0.125) == "a position 0.25 m outside the sphere"

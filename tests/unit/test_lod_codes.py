"""Level codes and their boundaries."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tilesnav_ref.lod import LodSettings, level_codes, thresholds


def test_powers_of_two_are_exact_boundaries() -> None:
    settings = LodSettings(reference=4.0, base=2.0, level_count=30)
    for code in range(1, 29):
        edge = 4.0 * 2.0**-code
        values = np.array([np.nextafter(edge, np.inf), edge, np.nextafter(edge, 0.0)])
        assert level_codes(values, settings).tolist() == [code - 1, code, code]


def test_ends_of_the_scale() -> None:
    settings = LodSettings()
    assert level_codes(np.array([math.inf, 1e9, 1.0, 1e-9, 0.0]), settings).tolist() == [0, 0, 0, 15, 15]


def test_codes_follow_the_formula() -> None:
    settings = LodSettings(reference=0.7, base=1.3, level_count=40)
    values = np.exp(np.random.default_rng(0).uniform(-12, 2, 2000))
    expected = np.clip(np.floor(np.log(0.7 / values) / np.log(1.3)), 0, 39)
    assert np.array_equal(level_codes(values, settings), expected)
    assert np.all(np.diff(thresholds(settings)) < 0)


def test_one_level_has_one_code() -> None:
    assert level_codes(np.array([0.0, 1.0, math.inf]), LodSettings(level_count=1)).tolist() == [0, 0, 0]


def test_huge_scale_does_not_overflow() -> None:
    settings = LodSettings(base=1e9, level_count=256)
    assert level_codes(np.array([0.0, 1e-10, 1.0]), settings).tolist() == [255, 1, 0]


@pytest.mark.parametrize("value", [-1.0, math.nan])
def test_what_is_no_level_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="allowed: 0 or greater"):
        level_codes(np.array([1.0, value]), LodSettings())


@pytest.mark.parametrize(
    "settings",
    [
        LodSettings(reference=0.0),
        LodSettings(reference=math.inf),
        LodSettings(base=1.0),
        LodSettings(base=math.nan),
        LodSettings(level_count=0),
        LodSettings(level_count=257),
    ],
)
def test_scale_out_of_range_is_refused(settings: LodSettings) -> None:
    with pytest.raises(ValueError, match="allowed"):
        thresholds(settings)

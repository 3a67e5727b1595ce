"""Signs of determinants against Python integers."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tilesnav_ref.visibility.exact import determinant_sign, exact_determinant_sign, orientation

LIMIT = 2**30 - 1
number = st.integers(-LIMIT, LIMIT) | st.integers(-3, 3) | st.sampled_from([LIMIT, -LIMIT, LIMIT - 1])
vector = st.tuples(number, number, number)


def reference(u, v, w):
    x = v[1] * w[2] - v[2] * w[1]
    y = v[2] * w[0] - v[0] * w[2]
    z = v[0] * w[1] - v[1] * w[0]
    value = u[0] * x + u[1] * y + u[2] * z
    return (value > 0) - (value < 0)


def as_float(v):
    return tuple(float(x) for x in v)


@given(vector, vector, vector)
def test_sign_of_any_three_vectors(u, v, w):
    floats = as_float(u), as_float(v), as_float(w)
    assert determinant_sign(*floats) == reference(u, v, w)
    assert exact_determinant_sign(*floats) == reference(u, v, w)


factor = st.integers(-3, 3)
nudges = st.tuples(st.integers(-1, 1), st.integers(-1, 1), st.integers(-1, 1))


@given(vector, vector, factor, factor, nudges)
def test_sign_of_nearly_dependent_vectors(u, v, a, b, nudge):
    w = tuple(max(-LIMIT, min(LIMIT, a * x + b * y + n)) for x, y, n in zip(u, v, nudge, strict=True))
    floats = as_float(u), as_float(v), as_float(w)
    assert determinant_sign(*floats) == reference(u, v, w)
    assert exact_determinant_sign(*floats) == reference(u, v, w)


def test_largest_terms_do_not_overflow():
    u, v, w = (LIMIT, LIMIT, LIMIT), (LIMIT, -LIMIT, LIMIT), (-LIMIT, LIMIT, LIMIT)
    assert exact_determinant_sign(as_float(u), as_float(v), as_float(w)) == reference(u, v, w) != 0


def test_orientation_of_the_unit_corner_and_its_mirror():
    o, x, y, z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    assert orientation(o, x, y, z) == 1
    assert orientation(o, y, x, z) == -1
    assert orientation(o, x, y, (5.0, -7.0, 0.0)) == 0


def test_one_unit_off_a_plane_of_full_extent_is_seen():
    far = 2.0**28
    plane = (-far, -far, -far), (far, -far, far), (far, far, far - 1)
    base = np.array([plane[0], plane[1], plane[2]])
    on = tuple(base[0] + (base[1] - base[0]) + (base[2] - base[1]) / 1.0)
    assert orientation(*plane, on) == 0
    up = (on[0], on[1], on[2] + 1)
    down = (on[0], on[1], on[2] - 1)
    assert orientation(*plane, up) * orientation(*plane, down) == -1

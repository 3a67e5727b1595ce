"""Signs of determinants against integers of any size."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tilesnav_validator.signs import determinant, turn

SIZES = st.sampled_from([2, 2**10, 2**30, 2**53, 2**61])


def vectors(size: int) -> st.SearchStrategy[list[int]]:
    return st.lists(st.integers(-size, size), min_size=3, max_size=3)


def exact(a: list[int], b: list[int], c: list[int]) -> int:
    value = (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    return (value > 0) - (value < 0)


def one(a: list[int], b: list[int], c: list[int]) -> int:
    return int(determinant(*(np.array([row], dtype=np.int64) for row in (a, b, c)))[0])


@given(data=st.data(), size=SIZES)
def test_determinants(data: st.DataObject, size: int) -> None:
    a, b, c = (data.draw(vectors(size)) for _ in range(3))
    assert one(a, b, c) == exact(a, b, c)


@settings(max_examples=300)
@given(data=st.data(), size=st.sampled_from([2**10, 2**29, 2**40, 2**58]), off=vectors(1))
def test_determinants_of_rows_that_almost_lie_in_a_plane(
    data: st.DataObject, size: int, off: list[int]
) -> None:
    a, b = (data.draw(vectors(size)) for _ in range(2))
    m, n = data.draw(st.integers(-4, 4)), data.draw(st.integers(-4, 4))
    c = [m * x + n * y + z for x, y, z in zip(a, b, off, strict=True)]
    assert one(a, b, c) == exact(a, b, c)


def test_what_64_bits_cannot_hold_is_counted_in_larger_integers() -> None:
    big = 2**60 + 1
    rows = [[big, big - 1, 1], [big + 1, big, 1], [0, 0, 1]]
    assert one(*rows) == exact(*rows) == 1  # big^2 - (big^2 - 1), times 1: lost in float64
    for some in (big, 2**37):
        rows = [[some, some - 2, 0], [some + 2, some, 0], [0, 0, 2**62 - 1]]
        assert one(*rows) == exact(*rows) == 1  # 4 (2^62 - 1), which is -4 modulo 2^64
    rows = [[big, big, big], [big, big, big], [1, 2, 3]]
    assert one(*rows) == 0


def test_determinants_are_broadcast() -> None:
    a = np.array([[[1, 0, 0]], [[-1, 0, 0]]])
    b, c = np.array([[0, 1, 0], [0, 0, 0], [0, -1, 0]]), np.array([0, 0, 1])
    assert determinant(a, b, c).tolist() == [[1, 0, -1], [-1, 0, 1]]


@given(
    st.lists(st.integers(-(2**30), 2**30), min_size=2, max_size=2),
    st.lists(st.integers(-(2**55), 2**55), min_size=2, max_size=2),
    st.integers(-(2**24), 2**24),
    st.booleans(),
)
def test_turns(a: list[int], b: list[int], times: int, along: bool) -> None:
    if along:  # almost in the direction of a
        b = [a[0] * times, a[1] * times + 1]
    value = a[0] * b[1] - a[1] * b[0]
    parts = (np.array([x], dtype=np.int64) for x in (*a, *b))
    assert int(turn(*parts)[0]) == (value > 0) - (value < 0)

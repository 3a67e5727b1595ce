"""The container of the nav file, against bytes worked out by hand."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from tilesnav_ref.tileset.container import TablePool, nav_file_parts


def test_literal_bytes() -> None:
    pool = TablePool()
    assert pool.add(np.array([1, 258, 2**32 - 1]), "<u4") == 0
    assert pool.add(np.array([7, 8]), "u1") == 1
    file = b"".join(nav_file_parts(pool, {"a": 1}))
    text = (
        b'{"buffers":[{"byteLength":18}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":12},'
        b'{"buffer":0,"byteOffset":16,"byteLength":2}],"a":1}'
    )
    assert len(text) == 141
    expected = (
        bytes.fromhex("6e617631 01000000 9000000000000000 1800000000000000")  # 144 and 24 bytes follow
        + text
        + b"   "
        + bytes.fromhex("01000000 02010000 ffffffff 00000000")  # three numbers, then to a multiple of 8
        + bytes.fromhex("0708 000000000000")  # two bytes, then the padding of the binary part
    )
    assert file == expected


def test_empty_table_and_no_padding_where_none_is_due() -> None:
    pool = TablePool()
    pool.add(np.empty(0), "<f8")
    pool.add(np.array([1.5]), "<f8")
    file = b"".join(nav_file_parts(pool, {}))
    assert pool.views == [
        {"buffer": 0, "byteOffset": 0, "byteLength": 0},
        {"buffer": 0, "byteOffset": 0, "byteLength": 8},
    ]
    json_length, binary_length = struct.unpack_from("<QQ", file, 8)
    assert len(file) == 24 + json_length + binary_length
    assert binary_length == 8
    assert file[-8:] == struct.pack("<d", 1.5)


@pytest.mark.parametrize(
    ("table", "dtype"),
    [(np.array([-1]), "<u4"), (np.array([2**32]), "<u4"), (np.array([256]), "u1"), (np.array([0.5]), "<u4")],
)
def test_an_element_that_does_not_fit_is_refused(table: np.ndarray, dtype: str) -> None:
    with pytest.raises(OverflowError, match="does not fit"):
        TablePool().add(table, dtype)

"""Arrays of a glTF document: buffers, buffer views and accessors (glTF 2.0, section 3.6)."""

from __future__ import annotations

import base64
import binascii
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.gltf.compressed import MESHOPT, decode_meshopt
from tilesnav_ref.scene.gltf.files import FILE_BYTES_LIMIT, Files
from tilesnav_ref.scene.gltf.values import Value, integer_or

TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
"""Accessors that are read; matrices are of skins and metadata."""


class Arrays:
    """Gives the arrays of a document.

    Parameters
    ----------
    files : Files
    path : Path
        File that the document is in; buffers that are files lie beside it.
    document : Value
    binary : memoryview
        The binary chunk; empty when there is none.
    limit : int
        Elements that an accessor may have.
    """

    def __init__(self, files: Files, path: Path, document: Value, binary: memoryview, limit: int) -> None:
        self._files, self._path, self._binary, self._limit = files, path, binary, limit
        self._buffers = document.items("buffers")
        self._views = document.items("bufferViews")
        self._accessors = document.items("accessors")
        self._read: dict[int, memoryview] = {}
        self._decoded: dict[int, memoryview] = {}
        self._decoded_bytes = 0

    def count(self, number: Value) -> int:
        """Elements that an accessor claims to have, within the limit."""
        return self._accessor(number).need("count").integer(0, self._limit)

    def indices(self, number: Value) -> NDArray[np.int64]:
        """Give the (count,) values of an accessor of unsigned integers.

        Raises
        ------
        SceneError
            When it is of another kind, or is not within its buffer.
        """
        accessor = self._accessor(number)
        if self._dtype(accessor).kind != "u":
            component = accessor.need("componentType")
            raise component.error(str(component.raw), "that of unsigned integers, as it holds indices")
        return self.array(number, 1)[:, 0].astype(np.int64)

    def array(self, number: Value, width: int) -> NDArray[np.float64]:
        """Give the values of an accessor.

        Parameters
        ----------
        number : Value
            Its index.
        width : int
            Components that an element has.

        Returns
        -------
        (count, width) float64
            Normalized integers as the fractions that they stand for.

        Raises
        ------
        SceneError
            When it is of another kind, or is not within its buffer.
        """
        accessor = self._accessor(number)
        count = self.count(number)
        dtype = self._dtype(accessor)
        kind = accessor.need("type").one_of(tuple(WIDTHS))
        if WIDTHS[kind] != width:
            raise accessor.error(f"type {kind}", f"{width} components")
        view = accessor.member("bufferView")
        if view is None:
            values = np.zeros((count, width), dtype)
        else:
            values = self._elements(accessor, view, (count, width), dtype)
        sparse = accessor.member("sparse")
        if sparse is not None:
            values = self._with_sparse(sparse, values)
        elif view is None:
            raise accessor.error("neither bufferView nor sparse", "one of them, as all would be zero")
        normalized = accessor.member("normalized")
        if normalized is not None and normalized.raw is True and dtype.kind != "f":
            # glTF 2.0, section 3.6.2.2: the least signed integer stands for -1, as its neighbour does
            return np.maximum(values.astype(np.float64) / float(np.iinfo(dtype).max), -1.0)
        return values.astype(np.float64)

    def view(self, number: Value) -> memoryview:
        """Bytes of a buffer view, decompressed where it is compressed."""
        if not self._views:
            raise number.error("no bufferViews", "one that it is in")
        index = number.integer(0, len(self._views) - 1)
        view = self._views[index]
        extensions = view.member("extensions")
        for name in MESHOPT:
            packed = None if extensions is None else extensions.member(name)
            if packed is not None:
                return self._meshopt(index, packed)
        return self._slice(view, integer_or(view.member("byteOffset"), 0, FILE_BYTES_LIMIT))

    def _accessor(self, number: Value) -> Value:
        if not self._accessors:
            raise number.error("no accessors", "one with this number")
        return self._accessors[number.integer(0, len(self._accessors) - 1)]

    def _dtype(self, accessor: Value) -> np.dtype:
        component = accessor.need("componentType")
        if component.integer(0, 1 << 16) not in TYPES:
            raise component.error(str(component.raw), ", ".join(map(str, TYPES)))
        return np.dtype(TYPES[component.raw])

    def _elements(
        self, place: Value, number: Value, shape: tuple[int, int], dtype: np.dtype
    ) -> NDArray[np.generic]:
        """Elements in a buffer view, with its stride."""
        data = self.view(number)
        view = self._views[number.raw]
        row = shape[1] * dtype.itemsize
        stride = integer_or(view.member("byteStride"), row, 1 << 16) or row
        start = integer_or(place.member("byteOffset"), 0, FILE_BYTES_LIMIT)
        end = start + (shape[0] - 1) * stride + row if shape[0] else start
        if stride < row or end > len(data):
            found = f"{shape[0]} elements of {row} bytes at every {stride} from {start}"
            raise place.error(found, f"elements apart, within the {len(data)} bytes of the view")
        if not shape[0]:
            return np.zeros(shape, dtype)
        flat = np.frombuffer(data, np.uint8, end - start, start)
        rows = np.lib.stride_tricks.as_strided(flat, (shape[0], row), (stride, 1), writeable=False)
        return np.ascontiguousarray(rows).view(dtype).reshape(shape)

    def _with_sparse(self, sparse: Value, values: NDArray[np.generic]) -> NDArray[np.generic]:
        """Replace the elements that a sparse accessor states."""
        count = sparse.need("count").integer(1, max(1, len(values)))
        indices, replacing = sparse.need("indices"), sparse.need("values")
        dtype = self._dtype(indices)
        at = self._elements(indices, indices.need("bufferView"), (count, 1), dtype)[:, 0]
        if dtype.kind != "u" or int(at.max()) >= len(values):
            raise indices.error(f"{dtype.name} up to {at.max()}", f"unsigned integers below {len(values)}")
        shape = (count, values.shape[1])
        result = values.copy()
        result[at] = self._elements(replacing, replacing.need("bufferView"), shape, values.dtype)
        return result

    def _meshopt(self, index: int, packed: Value) -> memoryview:
        if index not in self._decoded:
            start = integer_or(packed.member("byteOffset"), 0, FILE_BYTES_LIMIT)
            data = self._slice(packed, start)
            room = FILE_BYTES_LIMIT - self._decoded_bytes
            self._decoded[index] = memoryview(decode_meshopt(packed, data, self._limit, room))
            self._decoded_bytes += len(self._decoded[index])
        return self._decoded[index]

    def _slice(self, view: Value, start: int) -> memoryview:
        length = view.need("byteLength").integer(0, FILE_BYTES_LIMIT)
        buffer = self._buffer(view.need("buffer"))
        if start + length > len(buffer):
            raise view.error(f"bytes {start} to {start + length}", f"within the {len(buffer)} of the buffer")
        return buffer[start : start + length]

    def _buffer(self, number: Value) -> memoryview:
        if not self._buffers:
            raise number.error("no buffers", "one that it is in")
        index = number.integer(0, len(self._buffers) - 1)
        if index not in self._read:
            buffer = self._buffers[index]
            length = buffer.need("byteLength").integer(0, FILE_BYTES_LIMIT)
            data = self._data(buffer, index)
            if length > len(data):
                raise buffer.error(f"byteLength {length}", f"at most the {len(data)} bytes that are there")
            self._read[index] = data[:length]
        return self._read[index]

    def _data(self, buffer: Value, index: int) -> memoryview:
        uri = buffer.member("uri")
        if uri is None:
            return self._binary if index == 0 else memoryview(b"")
        if not uri.text().startswith("data:"):
            return memoryview(self._files.read(self._files.named(uri, self._path)))
        try:
            return memoryview(base64.b64decode(uri.text().partition(",")[2], validate=True))
        except (binascii.Error, ValueError) as error:
            raise uri.error(str(error), "data in base64") from error

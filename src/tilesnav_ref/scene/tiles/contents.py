"""From the content of a tile to parts: one for each feature, or one for each placed primitive."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.parts import Part
from tilesnav_ref.scene.tiles.containers import Batched, open_b3dm, open_cmpt
from tilesnav_ref.scene.tiles.files import Files
from tilesnav_ref.scene.tiles.geometry import Budget, Geometry, read_model, split_glb
from tilesnav_ref.scene.tiles.values import parse
from tilesnav_ref.scene.tiles.walk import Placed

UNREAD = {b"i3dm": "i3dm", b"pnts": "pnts", b"vctr": "vctr", b"geom": "geom"}
"""Tile formats without triangles of their own, or with instances of them."""
KINDS = "b3dm, cmpt, glTF (binary or JSON); i3dm, pnts, vctr, geom and GeoJSON are left out"


class Contents:
    """Reads contents and counts what is left out.

    Parameters
    ----------
    files : Files
    max_faces : int
        Faces of all contents.
    materials : bool
        Whether the labels of parts hold the names of their materials.
    """

    def __init__(self, files: Files, max_faces: int, materials: bool) -> None:
        self.left_out: Counter[str] = Counter()
        """Contents without readable triangles, by format."""
        self.primitives_left_out = 0
        """Sets of points or lines in contents that were read."""
        self.count = 0
        """Contents that gave faces."""
        self._files, self._faces, self._materials = files, max_faces, materials
        self._elements = 3 * max_faces

    def read(self, placed: Placed) -> list[Part]:
        """Read the parts of a content, in the axes of the entry tileset.

        Raises
        ------
        SceneError
            When it is of no known format, or is wrong.
        """
        data, source = memoryview(placed.data), str(placed.path)
        magic = bytes(data[:4])
        if magic == b"cmpt":
            inner = open_cmpt(source, "cmpt", data)
        elif placed.path.suffix.lower() == ".geojson":
            inner = iter(())
            self.left_out["GeoJSON"] += 1
        else:
            inner = iter((("", data),))
        parts = [part for place, tile in inner for part in self._tile(placed, place, tile)]
        self.count += bool(parts)
        return parts

    def _tile(self, placed: Placed, place: str, data: memoryview) -> list[Part]:
        """Read a content, or one of a composite."""
        source, magic = str(placed.path), bytes(data[:4])
        if magic in UNREAD:
            self.left_out[UNREAD[magic]] += 1
            return []
        batched = Batched(data, np.zeros(3), ())
        if magic == b"b3dm":
            batched = open_b3dm(source, f"{place} b3dm".strip(), data)
        elif not data:
            raise SceneError(source, place or "file", "0 bytes", KINDS)
        if bytes(batched.glb[:4]) == b"glTF":
            content = split_glb(source, f"{place} glTF".strip(), batched.glb)
        elif magic != b"b3dm" and bytes(data[:64]).removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{":
            content = parse(source, "", bytes(data)), memoryview(b"")
        else:
            raise SceneError(source, f"{place} magic".strip(), repr(bytes(batched.glb[:4])), KINDS)
        budget = Budget(self._faces, self._elements, self._materials)
        model = read_model(self._files, placed.path, content, placed.up, budget)
        self.primitives_left_out += model.skipped
        moved = placed.matrix @ _translation(batched.center)
        name = self._files.name(placed.path)
        grouped = _Grouped(name, batched.texts)
        for geometry in model.geometries:
            self._faces -= len(geometry.primitive.faces)
            grouped.add(source, geometry, moved @ geometry.matrix)
        return grouped.parts()


def _translation(center: NDArray[np.float64]) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, 3] = center
    return matrix


class _Grouped:
    """Parts of a content: faces of the same feature and the same names are one."""

    def __init__(self, name: str, texts: tuple[tuple[str, ...], ...]) -> None:
        self._name, self._texts = name, texts
        self._pieces: dict[tuple[str, tuple[str, ...]], list[tuple[NDArray, NDArray]]] = {}

    def add(self, source: str, geometry: Geometry, matrix: NDArray[np.float64]) -> None:
        """Add a placed primitive."""
        primitive = geometry.primitive
        with np.errstate(over="ignore", invalid="ignore"):  # refused below
            vertices = primitive.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        if not np.isfinite(vertices).all():
            raise SceneError(source, "transform", "a result that is not finite", "finite coordinates")
        faces = primitive.faces
        if np.linalg.det(matrix[:3, :3]) < 0:  # glTF 2.0, section 3.5.2: a mirrored mesh turns its faces
            faces = faces[:, ::-1]
        if primitive.feature is None:
            self._add((self._name, geometry.labels), vertices, faces)
            return
        order = np.argsort(primitive.feature, kind="stable")
        ids, starts = np.unique(primitive.feature[order], return_index=True)
        for number, chosen in zip(ids.tolist(), np.split(order, starts[1:]), strict=True):
            texts = self._texts[number] if 0 <= number < len(self._texts) else ()
            used, corners = np.unique(faces[chosen], return_inverse=True)
            name = f"{self._name}#{number}"
            self._add((name, (*geometry.labels, *texts)), vertices[used], corners.reshape(-1, 3))

    def _add(self, key: tuple[str, tuple[str, ...]], vertices: NDArray, faces: NDArray) -> None:
        self._pieces.setdefault(key, []).append((vertices, faces))

    def parts(self) -> list[Part]:
        """Give the parts, in the order in which they came."""
        found = []
        for (name, labels), pieces in self._pieces.items():
            starts = np.cumsum([0, *(len(vertices) for vertices, _ in pieces)])
            vertices = np.concatenate([piece[0] for piece in pieces])
            faces = np.concatenate([piece[1] + start for piece, start in zip(pieces, starts[:-1], strict=True)])
            if len(faces):
                found.append(Part(name, vertices, faces, tuple(dict.fromkeys((name, self._name, *labels)))))
        return found

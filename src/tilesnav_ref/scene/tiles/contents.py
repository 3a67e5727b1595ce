"""From the content of a tile to parts: one for each feature, or one for each placed primitive."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.files import Files
from tilesnav_ref.scene.gltf.grouping import Grouped
from tilesnav_ref.scene.gltf.model import Budget, read_model, split_glb
from tilesnav_ref.scene.gltf.values import parse
from tilesnav_ref.scene.parts import Part
from tilesnav_ref.scene.tiles.containers import Batched, open_b3dm, open_cmpt
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
        grouped = Grouped(batched.texts)
        for geometry in model.geometries:
            self._faces -= len(geometry.primitive.faces)
            grouped.add(source, name, geometry, moved @ geometry.matrix)
        return grouped.parts()


def _translation(center: NDArray[np.float64]) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, 3] = center
    return matrix

"""From placed primitives to parts: one for each feature, or for each name."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.model import Geometry
from tilesnav_ref.scene.parts import Part

Piece = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices and faces."""


class Grouped:
    """Parts of a file: faces of the same feature and the same names are one.

    Parameters
    ----------
    texts : tuple of tuple of str
        Further names of each feature.
    """

    def __init__(self, texts: tuple[tuple[str, ...], ...] = ()) -> None:
        self._texts = texts
        self._pieces: dict[tuple[str, tuple[str, ...]], list[Piece]] = {}

    def add(self, source: str, name: str, geometry: Geometry, matrix: NDArray[np.float64]) -> None:
        """Add a placed primitive under a name.

        Raises
        ------
        SceneError
            When the matrix makes coordinates that are not finite.
        """
        primitive = geometry.primitive
        with np.errstate(over="ignore", invalid="ignore"):  # refused below
            vertices = primitive.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        if not np.isfinite(vertices).all():
            raise SceneError(source, "transform", "a result that is not finite", "finite coordinates")
        faces = primitive.faces
        if np.linalg.det(matrix[:3, :3]) < 0:  # glTF 2.0, section 3.5.2: a mirrored mesh turns its faces
            faces = faces[:, ::-1]
        if primitive.feature is None:
            self._add((name, geometry.labels), (vertices, faces))
            return
        order = np.argsort(primitive.feature, kind="stable")
        ids, starts = np.unique(primitive.feature[order], return_index=True)
        for number, chosen in zip(ids.tolist(), np.split(order, starts[1:]), strict=True):
            texts = self._texts[number] if 0 <= number < len(self._texts) else ()
            used, corners = np.unique(faces[chosen], return_inverse=True)
            labels = (name, *geometry.labels, *texts)
            self._add((f"{name}#{number}", labels), (vertices[used], corners.reshape(-1, 3)))

    def _add(self, key: tuple[str, tuple[str, ...]], piece: Piece) -> None:
        self._pieces.setdefault(key, []).append(piece)

    def parts(self) -> list[Part]:
        """Give the parts, in the order in which they came."""
        found = []
        for (name, labels), pieces in self._pieces.items():
            starts = np.cumsum([0, *(len(vertices) for vertices, _ in pieces)])
            vertices = np.concatenate([piece[0] for piece in pieces])
            each = zip(pieces, starts[:-1], strict=True)
            faces = np.concatenate([piece[1] + start for piece, start in each])
            if len(faces):
                found.append(Part(name, vertices, faces, tuple(dict.fromkeys((name, *labels)))))
        return found

"""Nodes of a glTF scene: where each mesh is placed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.gltf.accessors import Arrays
from tilesnav_ref.scene.gltf.values import Value

INSTANCING = "EXT_mesh_gpu_instancing"


@dataclass(frozen=True)
class PlacedMesh:
    """A mesh and its places."""

    mesh: Value
    """Its number."""
    matrices: NDArray[np.float64]
    """(N, 4, 4) from the mesh to the scene: one, or one for each instance."""
    labels: tuple[str, ...]
    """Name of the node, if it has one."""


def placed_meshes(document: Value, arrays: Arrays, limit: int) -> Iterator[PlacedMesh]:
    """Go through the default scene of a document, depth first.

    Parameters
    ----------
    document : Value
    arrays : Arrays
        Of the document.
    limit : int
        Most instances of a node.

    Raises
    ------
    SceneError
        When a node comes twice, or a transform is no matrix.
    """
    nodes = document.items("nodes")
    seen: set[int] = set()
    stack = [(value, np.eye(4)) for value in reversed(_roots(document, nodes))]
    while stack:
        value, above = stack.pop()
        number = value.integer(0, len(nodes) - 1)
        if number in seen:
            raise value.error(f"node {number} a second time", "each node once, below one other")
        seen.add(number)
        node = nodes[number]
        matrix = above @ _matrix(node)
        mesh = node.member("mesh")
        if mesh is not None:
            name = node.member("name")
            labels = (name.raw,) if name is not None and isinstance(name.raw, str) and name.raw else ()
            yield PlacedMesh(mesh, matrix @ _instances(node, arrays, limit), labels)
        stack += [(child, matrix) for child in reversed(node.items("children"))]


def _roots(document: Value, nodes: list[Value]) -> list[Value]:
    """Root nodes of the default scene; without scenes all nodes that are below none."""
    scenes = document.items("scenes")
    if scenes:
        chosen = document.member("scene")
        return scenes[0 if chosen is None else chosen.integer(0, len(scenes) - 1)].items("nodes")
    below = {child.raw for node in nodes for child in node.items("children") if isinstance(child.raw, int)}
    return [Value(document.source, f"nodes[{i}]", i) for i in range(len(nodes)) if i not in below]


def _matrix(node: Value) -> NDArray[np.float64]:
    """Matrix of a node, by columns, or translation, rotation, scale."""
    value = node.member("matrix")
    if value is not None:
        return value.matrix()
    given = {name: node.member(name) for name in ("translation", "rotation", "scale")}
    defaults = {"translation": np.zeros(3), "rotation": np.array((0.0, 0.0, 0.0, 1.0)), "scale": np.ones(3)}
    move, turn, scale = (
        defaults[name] if value is None else value.numbers(len(defaults[name]))
        for name, value in given.items()
    )
    matrices = _composed(move[None], _unit(turn[None], node), scale[None])
    return matrices.reshape(4, 4)


def _unit(turns: NDArray[np.float64], place: Value) -> NDArray[np.float64]:
    """Quaternions x, y, z, w of length one."""
    length = np.linalg.norm(turns, axis=1, keepdims=True)
    if not (length > 0.5).all():  # glTF has unit quaternions; float32 and normalized bytes come near
        raise place.error(f"a rotation of length {float(length.min()):.3g}", "unit quaternions")
    return np.asarray(turns / length)


def _composed(
    moves: NDArray[np.float64], turns: NDArray[np.float64], scales: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 4, 4) translation times rotation times scale."""
    x, y, z, w = turns.T
    matrices = np.zeros((len(moves), 4, 4))
    rotation = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    matrices[:, :3, :3] = np.array(rotation).transpose(2, 0, 1) * scales[:, None, :]
    matrices[:, :3, 3] = moves
    matrices[:, 3, 3] = 1.0
    return matrices


def _instances(node: Value, arrays: Arrays, limit: int) -> NDArray[np.float64]:
    """(N, 4, 4) places of the instances of EXT_mesh_gpu_instancing; one when there are none."""
    extensions = node.member("extensions")
    extension = None if extensions is None else extensions.member(INSTANCING)
    if extension is None:
        return np.eye(4)[None]
    attributes = extension.need("attributes")
    given = {name: attributes.member(name) for name in ("TRANSLATION", "ROTATION", "SCALE")}
    counts = {arrays.count(value) for value in given.values() if value is not None}
    if len(counts) != 1 or max(counts) > limit:
        raise attributes.error(f"counts {sorted(counts)}", f"one count for all, at most {limit}")
    count = counts.pop()
    values = {
        "TRANSLATION": np.zeros((count, 3)),
        "ROTATION": np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)),
        "SCALE": np.ones((count, 3)),
    }
    for name, value in given.items():
        if value is not None:
            values[name] = arrays.array(value, values[name].shape[1])
    turns = _unit(values["ROTATION"], attributes) if count else values["ROTATION"]
    return _composed(values["TRANSLATION"], turns, values["SCALE"])

"""One binary glTF for each content, with positions that are grid coordinates exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pygltflib as gltf
from numpy.typing import NDArray

from tilesnav_ref import __version__
from tilesnav_ref.scene.model import COORDINATE_LIMIT, Scene
from tilesnav_ref.scene.planes import PlaneTable
from tilesnav_ref.tileset.plane_table import ATTRIBUTE, add_plane_table, feature_ids

PRIMITIVE_RESTART = {"<u2": 0xFFFF, "<u4": 0xFFFFFFFF}
"""glTF forbids the largest index of a type, which graphics interfaces take for the restart of a primitive."""


@dataclass(frozen=True)
class Content:
    """A content as it is written."""

    data: bytes
    """The glb file."""
    face_count: int
    object_count: int
    lower: NDArray[np.int64]
    """(3,) least grid coordinates of its positions, nav frame."""
    upper: NDArray[np.int64]
    """(3,) greatest grid coordinates."""
    porous: tuple[int, ...] = ()
    """Ascending indices of the objects within the content that hide nothing."""
    one_sided: tuple[int, ...] = ()
    """Ascending indices of the objects within the content that are seen from their front only."""


@dataclass(frozen=True)
class _Primitive:
    name: str
    positions: NDArray[np.float32]
    """(V, 3) metres, glTF frame (y up)."""
    indices: NDArray[np.uint32]
    """(3F,)."""
    planes: NDArray[np.int64] | None = None
    """(V,) plane of each vertex, where the faces lie on planes of a survey."""

    @property
    def index_type(self) -> str:
        """The smallest of the two index types that every graphics interface knows."""
        return "<u2" if len(self.positions) <= PRIMITIVE_RESTART["<u2"] else "<u4"


def make_content(scene: Scene, content: int) -> Content:
    """Make the glb of one content: one mesh with one TRIANGLES primitive for each object, in their order.

    Raises
    ------
    ValueError
        When a coordinate is outside of the grid, so that float32 does not hold it exactly.
    """
    objects = np.flatnonzero(scene.object_content == content)
    bounds = np.searchsorted(scene.face_object, [objects[0], objects[-1] + 1])
    grid = scene.vertices[scene.faces[bounds[0] : bounds[1]]].reshape(-1, 3)
    primitives = [_primitive(scene, int(number)) for number in objects]
    return Content(
        data=_glb(primitives, scene.planes),
        face_count=int(bounds[1] - bounds[0]),
        object_count=len(objects),
        lower=grid.min(axis=0),
        upper=grid.max(axis=0),
        porous=_flagged(scene.object_porous, objects),
        one_sided=_flagged(scene.object_one_sided, objects),
    )


def _flagged(flags: NDArray[np.bool_], objects: NDArray[np.int64]) -> tuple[int, ...]:
    """Positions among the objects of a content of those that have a flag; `flags` is empty when none has."""
    return tuple(np.flatnonzero(flags[objects]).tolist()) if len(flags) else ()


def gltf_positions(grid: NDArray[np.int64], step: float) -> NDArray[np.float32]:
    """Turn grid coordinates of the nav frame into float32 metres of glTF's y-up frame, exactly.

    Parameters
    ----------
    grid : (V, 3) int64
        Nav frame, z up.
    step : float
        Metres; a power of two.

    Returns
    -------
    (V, 3) float32

    Raises
    ------
    ValueError
        When a coordinate does not survive: the grid has 24 bits, as has the significand of float32.
    """
    # Negated as integers: a negated float32 zero would be written as -0.0.
    turned = np.stack((grid[:, 0], grid[:, 2], -grid[:, 1]), axis=1)
    positions = (turned * step).astype(np.float32)
    decoded = positions.astype(np.float64) / step
    if np.any(np.abs(turned) >= COORDINATE_LIMIT) or not np.array_equal(decoded, turned):
        worst = int(np.abs(turned).max())
        raise ValueError(
            f"grid coordinate of magnitude {worst} is not exact in float32 (limit {COORDINATE_LIMIT})"
        )
    return positions


def _primitive(scene: Scene, number: int) -> _Primitive:
    first, last = np.searchsorted(scene.face_object, [number, number + 1])
    if first == last:
        raise ValueError(f"object {number} ({scene.object_names[number]!r}) has no faces")
    faces, name = scene.faces[first:last], scene.object_names[number]
    if scene.planes is None:
        used, indices = np.unique(faces, return_inverse=True)
        positions = gltf_positions(scene.vertices[used], scene.step)
        return _Primitive(name, positions, indices.reshape(-1).astype(np.uint32))
    # a vertex of two planes is written twice, since an id belongs to a vertex
    keys = np.column_stack((np.repeat(scene.planes.face_plane[first:last], 3), faces.reshape(-1)))
    pairs, indices = np.unique(keys, axis=0, return_inverse=True)
    positions = gltf_positions(scene.vertices[pairs[:, 1]], scene.step)
    return _Primitive(name, positions, indices.reshape(-1).astype(np.uint32), pairs[:, 0].astype(np.int64))


def _glb(primitives: list[_Primitive], planes: PlaneTable | None) -> bytes:
    positions = np.concatenate([p.positions for p in primitives])
    document = gltf.GLTF2(
        asset=gltf.Asset(version="2.0", generator=f"tilesnav {__version__}"),
        scene=0,
        scenes=[gltf.Scene(nodes=[0])],
        nodes=[gltf.Node(mesh=0)],
        meshes=[gltf.Mesh(primitives=[])],
        # Faces are two-sided surfaces of stone; the default of glTF is bare metal.
        materials=[
            gltf.Material(
                doubleSided=True,
                pbrMetallicRoughness=gltf.PbrMetallicRoughness(metallicFactor=0.0, roughnessFactor=1.0),
            )
        ],
        bufferViews=[_vertex_view(positions.nbytes)],
    )
    blob = [positions.astype("<f4").tobytes()]
    length = len(blob[0])
    views: dict[str, int] = {}
    for index_type in ("<u2", "<u4"):
        chosen = [p.indices for p in primitives if p.index_type == index_type]
        if chosen:
            data = np.concatenate(chosen).astype(index_type).tobytes()
            views[index_type] = len(document.bufferViews)
            document.bufferViews.append(_index_view(length, len(data)))
            blob.append(data + b"\0" * (-len(data) % 4))
            length += len(blob[-1])
    _add_primitives(document, primitives, views)
    if planes is not None:
        _add_planes(document, blob, planes, primitives)
    document.buffers = [gltf.Buffer(byteLength=sum(map(len, blob)))]
    document.set_binary_blob(b"".join(blob))
    return b"".join(document.save_to_bytes())


def _add_primitives(document: gltf.GLTF2, primitives: list[_Primitive], views: dict[str, int]) -> None:
    vertex_offset = 0
    index_offsets = dict.fromkeys(views, 0)
    for primitive in primitives:
        kind = primitive.index_type
        first = len(document.accessors)
        document.accessors.append(_position_accessor(primitive.positions, vertex_offset))
        document.accessors.append(
            gltf.Accessor(
                bufferView=views[kind],
                byteOffset=index_offsets[kind],
                componentType=gltf.UNSIGNED_SHORT if kind == "<u2" else gltf.UNSIGNED_INT,
                count=len(primitive.indices),
                type=gltf.SCALAR,
            )
        )
        document.meshes[0].primitives.append(
            gltf.Primitive(
                attributes=gltf.Attributes(POSITION=first),
                indices=first + 1,
                material=0,
                mode=gltf.TRIANGLES,
                extras={"name": primitive.name},
            )
        )
        vertex_offset += primitive.positions.nbytes
        index_offsets[kind] += len(primitive.indices) * np.dtype(kind).itemsize


def _add_planes(
    document: gltf.GLTF2, blob: list[bytes], planes: PlaneTable, primitives: list[_Primitive]
) -> None:
    """Add the plane of every vertex, as float32 because attributes are aligned to four bytes, and the table.

    Numbers of planes below 2**24 are exact in float32; a content has fewer faces than that. Vertices of no
    plane get the number behind the last row, which is declared to be none.
    """
    given = [primitive.planes for primitive in primitives if primitive.planes is not None]
    every = np.concatenate(given)
    used = np.unique(every[every >= 0])
    if not len(used):
        return  # a table has a row or more
    rows = np.where(every >= 0, np.searchsorted(used, every), len(used))
    offset = sum(map(len, blob))
    blob.append(rows.astype("<f4").tobytes())
    document.bufferViews.append(
        gltf.BufferView(
            buffer=0, byteOffset=offset, byteLength=len(blob[-1]), byteStride=4, target=gltf.ARRAY_BUFFER
        )
    )
    view, start = len(document.bufferViews) - 1, 0
    for written, of_vertices in zip(document.meshes[0].primitives, given, strict=True):
        accessor = gltf.Accessor(
            bufferView=view,
            byteOffset=4 * start,
            componentType=gltf.FLOAT,
            count=len(of_vertices),
            type=gltf.SCALAR,
        )
        setattr(written.attributes, ATTRIBUTE, len(document.accessors))
        document.accessors.append(accessor)
        written.extensions = feature_ids(len(np.unique(of_vertices[of_vertices >= 0])), len(used))
        start += len(of_vertices)
    add_plane_table(document, blob, planes, used)


def _position_accessor(positions: NDArray[np.float32], offset: int) -> gltf.Accessor:
    return gltf.Accessor(
        bufferView=0,
        byteOffset=offset,
        componentType=gltf.FLOAT,
        count=len(positions),
        type=gltf.VEC3,
        min=[float(v) for v in positions.min(axis=0)],
        max=[float(v) for v in positions.max(axis=0)],
    )


def _vertex_view(length: int) -> gltf.BufferView:
    return gltf.BufferView(buffer=0, byteOffset=0, byteLength=length, byteStride=12, target=gltf.ARRAY_BUFFER)


def _index_view(offset: int, length: int) -> gltf.BufferView:
    return gltf.BufferView(buffer=0, byteOffset=offset, byteLength=length, target=gltf.ELEMENT_ARRAY_BUFFER)

"""Planes of a survey in a content: feature ids and a property table.

References
----------
EXT_mesh_features and EXT_structural_metadata, Cesium GS, Inc., glTF 2.0 vendor extensions.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pygltflib as gltf
from numpy.typing import NDArray

from tilesnav_ref.scene.planes import PlaneTable

FEATURES, METADATA = "EXT_mesh_features", "EXT_structural_metadata"
ATTRIBUTE = "_FEATURE_ID_0"
_ALIGNMENT = 8
"""Bytes to whose multiples EXT_structural_metadata aligns the values of a property."""
_PROPERTIES: dict[str, tuple[str, str, str, str]] = {
    "id": ("SCALAR", "UINT32", "<u4", "number of the plane in the whole map"),
    "normal": ("VEC3", "FLOAT64", "<f8", "unit normal n, in the frame of this file (y up)"),
    "offset": ("SCALAR", "FLOAT64", "<f8", "d, metres: n.x + d = 0 on the plane"),
    "centre": ("VEC3", "FLOAT64", "<f8", "middle of the extent rectangle, metres"),
    "axisLong": ("VEC3", "FLOAT64", "<f8", "unit vector along its longer side"),
    "axisShort": ("VEC3", "FLOAT64", "<f8", "unit vector along its shorter side"),
    "halfSize": ("VEC2", "FLOAT64", "<f8", "half of its longer and of its shorter side, metres"),
    "area": ("SCALAR", "FLOAT64", "<f8", "area of the faces of the plane in the whole map, square metres"),
    "rms": ("SCALAR", "FLOAT64", "<f8", "root mean square distance of the inliers, metres"),
    "inlierCount": ("SCALAR", "UINT32", "<u4", "points of the survey on the plane"),
    "covariance": ("MAT3", "FLOAT64", "<f8", "covariance of the inliers, square metres"),
}
_TURN = np.array(((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))
"""From the nav frame (z up) to that of glTF (y up)."""


def add_plane_table(
    document: gltf.GLTF2, blob: list[bytes], planes: PlaneTable, used: NDArray[np.int64]
) -> None:
    """Add schema and table to a document, and the values to the parts of its buffer.

    Parameters
    ----------
    document : GLTF2
        Its buffer views are extended.
    blob : list of bytes
        Parts of the buffer; padded, then extended.
    planes : PlaneTable
    used : (M,) int64
        Planes that the file needs, ascending; rows of the table.
    """
    length = sum(map(len, blob))
    members: dict[str, Any] = {}
    for name, column in _columns(planes, used).items():
        padding = -length % _ALIGNMENT
        data = np.ascontiguousarray(column, _PROPERTIES[name][2]).tobytes()
        document.bufferViews.append(
            gltf.BufferView(buffer=0, byteOffset=length + padding, byteLength=len(data))
        )
        blob += [b"\0" * padding, data]
        length += padding + len(data)
        members[name] = {"values": len(document.bufferViews) - 1}
    blob.append(b"\0" * (-length % 4))
    table = {"name": "planes", "class": "plane", "count": len(used), "properties": members}
    document.extensions[METADATA] = {"schema": _schema(), "propertyTables": [table]}
    document.extensionsUsed += [FEATURES, METADATA]


def feature_ids(count: int, none: int) -> dict[str, Any]:
    """Extensions of a primitive whose vertices have feature ids: `count` different ones, or `none` for no
    plane. Where it has no other, one is counted, since the schema of the extension asks for one or more."""
    feature: dict[str, Any] = {"featureCount": max(count, 1), "nullFeatureId": none}
    feature |= {"attribute": 0, "propertyTable": 0, "label": "plane"}
    return {FEATURES: {"featureIds": [feature]}}


def _schema() -> dict[str, Any]:
    properties = {
        name: {"type": kind, "componentType": component, "required": True, "description": text}
        for name, (kind, component, _, text) in _PROPERTIES.items()
    }
    described = "plane that was found in a point cloud"
    classes = {"plane": {"name": "Plane", "description": described, "properties": properties}}
    return {"id": "tilesnav_planes", "classes": classes}


def _columns(planes: PlaneTable, used: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
    """Values of every property in the frame of glTF; matrices column after column, here symmetric."""
    return {
        "id": used,
        "normal": planes.normals[used] @ _TURN.T,
        "offset": planes.offsets[used],
        "centre": planes.centres[used] @ _TURN.T,
        "axisLong": planes.axes[used, 0] @ _TURN.T,
        "axisShort": planes.axes[used, 1] @ _TURN.T,
        "halfSize": planes.half_sizes[used],
        "area": planes.areas[used],
        "rms": planes.rms[used],
        "inlierCount": planes.counts[used],
        "covariance": _TURN @ planes.covariances[used] @ _TURN.T,
    }

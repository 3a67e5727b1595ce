"""Face maps: which faces of level 0 those of a coarse content stand for, in the container of nav files."""

from __future__ import annotations

import numpy as np

from tilesnav_ref.levels.model import CoarseLevel
from tilesnav_ref.tileset.container import COUNT_LIMIT, Buffer, TablePool, nav_file_parts
from tilesnav_ref.tileset.errors import EncodeError

MAGIC = b"fmap"


def objects_of(level: CoarseLevel, content: int) -> slice:
    """Objects of a content."""
    first, last = np.searchsorted(level.scene.object_content, [content, content + 1])
    return slice(int(first), int(last))


def face_map_file(level: CoarseLevel, content: int) -> list[Buffer]:
    """Face map of a content of a coarse level, in parts to be written one behind the other.

    Raises
    ------
    EncodeError
        When there is more of anything than readers accept.
    """
    objects = objects_of(level, content)
    first, last = np.searchsorted(level.scene.face_object, [objects.start, objects.stop])
    offsets = level.offsets[first : last + 1]
    if offsets[-1] - offsets[0] > COUNT_LIMIT:
        raise EncodeError(f"a face map of {offsets[-1] - offsets[0]} pairs; allowed: {COUNT_LIMIT} or less")
    pool = TablePool()
    members = {
        "faceMap": {
            "objectCount": objects.stop - objects.start,
            "faceCount": int(last - first),
            "count": int(offsets[-1] - offsets[0]),
            "objects": pool.add(np.arange(objects.start, objects.stop), "<u4"),
            "errors": pool.add(level.errors[objects], "<f8"),
            "offsets": pool.add(offsets - offsets[0], "<u4"),
            "faces": pool.add(level.fine_faces[offsets[0] : offsets[-1]], "<u4"),
        }
    }
    return nav_file_parts(pool, members, MAGIC)

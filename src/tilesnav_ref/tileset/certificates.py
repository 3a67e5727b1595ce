"""Certificate files: proofs for the cells of one nav file, in the same container."""

from __future__ import annotations

from tilesnav_ref.tileset.container import COUNT_LIMIT, Buffer, TablePool, nav_file_parts
from tilesnav_ref.tileset.errors import EncodeError
from tilesnav_ref.visibility.certificates import Certificates

MAGIC = b"cert"


def certificate_file(certificates: Certificates, first: int, last: int) -> list[Buffer]:
    """Certificate file of the cells first, ..., last - 1, in parts to be written one behind the other.

    Raises
    ------
    EncodeError
        When there is more of anything than readers accept.
    """
    tables = certificates.tables(first, last)
    counts = {
        "count": len(tables.regions),
        "useCount": len(tables.uses),
        "targetCount": len(tables.targets),
        "cutCount": len(tables.cuts),
        "leafCount": len(tables.leaves),
        "occluderCount": len(tables.occluder_offsets) - 1,
        "occluderFaceCount": len(tables.occluders),
    }
    for name, number in counts.items():
        if number >= COUNT_LIMIT:
            raise EncodeError(f"certificates: {name} is {number}; allowed: less than {COUNT_LIMIT}")
    pool = TablePool()
    views = {
        "cellOffsets": pool.add(tables.cell_offsets, "<u4"),
        "uses": pool.add(tables.uses, "<u4"),
        "regions": pool.add(tables.regions, "<i4"),
        "shapes": pool.add(tables.shapes, "u1"),
        "targetOffsets": pool.add(tables.target_offsets, "<u4"),
        "targets": pool.add(tables.targets, "<u4"),
        "cutOffsets": pool.add(tables.cut_offsets, "<u4"),
        "cuts": pool.add(tables.cuts, "u1"),
        "leaves": pool.add(tables.leaves, "<u4"),
        "occluderOffsets": pool.add(tables.occluder_offsets, "<u4"),
        "occluders": pool.add(tables.occluders, "<u4"),
    }
    frame = certificates.frame
    members = {
        "sector": {"firstCell": first, "cellCount": last - first},
        "frame": {"origin": frame.origin.tolist(), "subdivision": frame.scale.bit_length() - 1},
        "certificates": {**counts, **views},
    }
    return nav_file_parts(pool, members, MAGIC)

"""Point cloud files for tests, written from their definitions."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

POINTS = np.array([(1.5, 2.25, 3.0), (-4.0, 5.5, 0.125), (7.0, -8.0, 9.75), (0.5, 0.25, -1.0)])
INTENSITIES = np.array((1.0, 20.0, 300.0, 4.0), np.float32)


def ply_bytes(kind: str, count: int = len(POINTS), extra: str = "") -> bytes:
    head = f"ply\nformat {kind} 1.0\n{extra}element vertex {count}\nproperty double x\nproperty double y\n"
    head += "property double z\nproperty float intensity\nend_header\n"
    if kind == "ascii":
        rows = [" ".join(f"{v}" for v in (*p, i)) for p, i in zip(POINTS, INTENSITIES, strict=True)]
        return (head + "\n".join(rows) + "\n").encode()
    order = "<" if kind == "binary_little_endian" else ">"
    rows = [struct.pack(f"{order}3df", *p, i) for p, i in zip(POINTS, INTENSITIES, strict=True)]
    return head.encode() + b"".join(rows)


def pcd_header(data: str, count: int = len(POINTS)) -> bytes:
    return (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 8 8 8 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
        f"WIDTH {count}\nHEIGHT 1\nVIEWPOINT 10 20 30 1 0 0 0\nPOINTS {count}\nDATA {data}\n"
    ).encode()


def pcd_bytes(data: str) -> bytes:
    if data == "ascii":
        rows = [" ".join(f"{v}" for v in (*p, i)) for p, i in zip(POINTS, INTENSITIES, strict=True)]
        return pcd_header(data) + "\n".join(rows).encode() + b"\n"
    if data == "binary":
        rows = [struct.pack("<3df", *p, i) for p, i in zip(POINTS, INTENSITIES, strict=True)]
        return pcd_header(data) + b"".join(rows)
    columns = POINTS.T.astype("<f8").tobytes() + INTENSITIES.tobytes()
    packed = lzf_literals(columns)
    return pcd_header(data) + struct.pack("<II", len(packed), len(columns)) + packed


def lzf_literals(data: bytes) -> bytes:
    """An LZF block of literals alone, which is valid and compresses nothing."""
    parts = [data[k : k + 32] for k in range(0, len(data), 32)]
    return b"".join(bytes([len(part) - 1]) + part for part in parts)


def write_las(path: Path, points: np.ndarray, wkt: str | None = None) -> None:
    """A LAS 1.4 file, point format 6, with class 2 for all but the last point, which is noise."""
    import laspy  # noqa: PLC0415 - optional; tests that call this have asked for it

    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = np.full(3, 0.001), np.floor(points.min(axis=0))
    if wkt is not None:
        header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(wkt))
        header.global_encoding.wkt = True
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    las.classification = np.append(np.full(len(points) - 1, 2), 7).astype(np.uint8)
    las.return_number = np.ones(len(points), np.uint8)
    las.number_of_returns = np.full(len(points), 2, np.uint8)
    las.intensity = np.arange(len(points)).astype(np.uint16)
    las.write(path)

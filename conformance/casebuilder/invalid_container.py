"""Invalid nav files: header, padding, JSON part, buffer views, tables, offsets and counts."""

from __future__ import annotations

import struct

import numpy as np

from casebuilder.assemble import Files, Json
from casebuilder.container import dumps
from casebuilder.edits import Edits, dropping, edits, in_table, of_first, setting, whole_table
from casebuilder.state import Tables
from casebuilder.worlds import SINGLE, TWO_SECTORS

TEN_GB = 10 * 2**30


def _header(data: bytes) -> tuple[int, int]:
    lengths = struct.unpack_from("<QQ", data, 8)
    return lengths[0], lengths[1]


def _with_lengths(data: bytes, text: int, binary: int) -> bytes:
    return data[:8] + struct.pack("<QQ", text, binary) + data[24:]


def _big_endian(data: bytes) -> bytes:
    return data[:4] + struct.pack(">IQQ", 1, *_header(data)) + data[24:]


def _overflow(data: bytes) -> bytes:
    return _with_lengths(data, 2**64 - 8, sum(_header(data)) + 8)


HEADER: dict[str, Edits] = {
    "container/header/magic": edits(nav=lambda d: b"nav2" + d[4:]),
    "container/header/version": edits(nav=lambda d: d[:4] + struct.pack("<I", 2) + d[8:]),
    "container/header/truncated": edits(nav=lambda d: d[: len(d) // 2]),
    "container/header/truncated-by-one-byte": edits(nav=lambda d: d[:-1]),
    "container/header/truncated-header": edits(nav=lambda d: d[:20]),
    "container/header/trailing-bytes": edits(nav=lambda d: d + bytes(8)),
    "container/header/big-endian": edits(nav=_big_endian),
    "container/header/claims-10-gb": edits(nav=lambda d: _with_lengths(d, _header(d)[0], TEN_GB)),
    "container/header/lengths-overflow": edits(nav=_overflow),
    "container/header/text-renamed": edits(nav=lambda _: b"This is no nav file.\n"),
    "container/header/empty-file": edits(nav=lambda _: b""),
}


def _repack(data: bytes, text: bytes, binary: bytes) -> bytes:
    return data[:8] + struct.pack("<QQ", len(text), len(binary)) + text + binary


def _parts(data: bytes) -> tuple[bytes, bytes]:
    text, _ = _header(data)
    return data[24 : 24 + text], data[24 + text :]


def _unpadded_json(data: bytes) -> bytes:
    text, binary = _parts(data)
    text = text.rstrip(b" ")
    return _repack(data, text + b" " * (3 if len(text) % 8 == 0 else 0), binary)


def _padded_with(data: bytes, fill: bytes) -> bytes:
    text, binary = _parts(data)
    text = text.rstrip(b" ")
    return _repack(data, text + fill * (8 + -len(text) % 8), binary)


def _unpadded_binary(data: bytes) -> bytes:
    text, binary = _parts(data)
    return _repack(data, text, binary[:-1])


def _dirty_binary(data: bytes) -> bytes:
    if data[-1] != 0:
        raise ValueError("the last byte is no padding")
    return data[:-1] + b"\xff"


PADDING: dict[str, Edits] = {
    "container/padding/json-not-padded": edits(nav=_unpadded_json),
    "container/padding/json-padded-with-tabs": edits(nav=lambda d: _padded_with(d, b"\t")),
    "container/padding/json-padded-with-zeros": edits(nav=lambda d: _padded_with(d, b"\0")),
    "container/padding/binary-not-padded": edits(nav=_unpadded_binary),
    "container/padding/binary-padded-with-ones": edits(nav=_dirty_binary),
}


def _json(data: bytes) -> bytes:
    return _parts(data)[0].rstrip(b" ")


def _replace_json(data: bytes, text: bytes) -> bytes:
    _, binary = _parts(data)
    return _repack(data, text + b" " * (-len(text) % 8), binary)


DEEP = b'{"extras":' + b"[" * 100000 + b"]" * 100000 + b"," + dumps({"buffers": []})[1:]

JSON: dict[str, Edits] = {
    "container/json/not-json": edits(nav=lambda d: _replace_json(d, _json(d)[:-1])),
    "container/json/not-utf-8": edits(nav=lambda d: _replace_json(d, b'{"extras":"\xff",' + _json(d)[1:])),
    "container/json/not-an-object": edits(nav=lambda d: _replace_json(d, b"[]")),
    "container/json/no-deltas": edits(nav_json=of_first(dropping("deltas"))),
    "container/json/nested-too-deep": edits(nav=lambda d: _replace_json(d, DEEP)),
}


def _add_view_beyond(part: Json, _parts: list[bytes]) -> None:
    end = -(-part["buffers"][0]["byteLength"] // 8) * 8
    part["bufferViews"].append({"buffer": 0, "byteOffset": end, "byteLength": 8})


def _claim(part: Json, _parts: list[bytes]) -> None:
    part["buffers"][0]["byteLength"] = TEN_GB
    start = part["bufferViews"][-1]["byteOffset"] + 64
    part["bufferViews"].append({"buffer": 0, "byteOffset": start, "byteLength": TEN_GB - start})


def _misalign(part: Json, parts: list[bytes]) -> None:
    last = part["bufferViews"][-1]
    start = last["byteOffset"]
    parts[0] = parts[0][:start] + bytes(4) + parts[0][start:]
    last["byteOffset"] += 4
    part["buffers"][0]["byteLength"] += 4


def _overlap(part: Json, _parts: list[bytes]) -> None:
    # enteredOffsets and leftOffsets have the same length; the two tables then read the same bytes.
    views, deltas = part["bufferViews"], part["deltas"]
    views[deltas["switchOffsets"]]["byteOffset"] = views[deltas["leftOffsets"]]["byteOffset"]


def _extra_bytes(_part: Json, parts: list[bytes]) -> None:
    parts[0] += bytes(-len(parts[0]) % 8 + 8)


VIEWS: dict[str, Edits] = {
    "container/buffer-views/beyond-the-end": edits(nav_json=_add_view_beyond),
    "container/buffer-views/claims-10-gb": edits(nav_json=_claim),
    "container/buffer-views/offset-overflows": edits(
        nav_json=of_first(setting("bufferViews", 0, "byteOffset", value=2**64 - 8))
    ),
    "container/buffer-views/not-aligned": edits(nav_json=_misalign),
    "container/buffer-views/overlap": edits(nav_json=_overlap),
    "container/buffer-views/buffer-too-short": edits(nav_json=_extra_bytes),
}


def _share_view(part: Json, _parts: list[bytes]) -> None:
    part["deltas"]["left"] = part["deltas"]["entered"]


def _end_early(sectors: list[Tables]) -> None:
    sectors[0]["pvs.offsets"][-1] -= 1


def _one_more(table: np.ndarray) -> np.ndarray:
    return np.append(table, np.zeros(1, table.dtype))


TABLES: dict[str, Edits] = {
    "container/table-lengths/one-kind-too-many": edits(tables=whole_table("cells.kinds", _one_more)),
    "container/table-lengths/one-code-too-few": edits(tables=whole_table("lod.codes", lambda t: t[:-1])),
    "container/table-lengths/huge-count": edits(nav_json=of_first(setting("pvs", "count", value=2**31))),
    "container/table-lengths/no-such-view": edits(nav_json=of_first(setting("pvs", "faces", value=999))),
    "container/table-lengths/shared-view": edits(world=SINGLE, nav_json=_share_view),
    "container/offsets/begins-with-one": edits(tables=in_table("pvs.offsets", 0, 1)),
    "container/offsets/ends-too-early": edits(tables=_end_early),
    "container/offsets/decreases": edits(tables=in_table("lod.offsets", 2, 1)),
    "container/offsets/beyond-the-end": edits(tables=in_table("deltas.enteredOffsets", 1, 2**32 - 1)),
    "container/offsets/polygons": edits(tables=in_table("portals.polygonOffsets", 1, 20)),
    "container/offsets/big-endian": edits(tables=whole_table("pvs.offsets", lambda t: t.astype(">u4"))),
}


def _local_numbers(files: Files) -> None:
    files["nav/1.nav"] = files["nav/1.nav"].replace(b'"firstCell":3', b'"firstCell":0')


COUNTS: dict[str, Edits] = {
    "container/sector-counts/first-cell": edits(world=TWO_SECTORS, files=_local_numbers),
    "container/sector-counts/gap": edits(
        entry=setting("sectors", 0, "firstCell", value=1),
        nav_json=of_first(setting("sector", "firstCell", value=1)),
    ),
    "container/sector-counts/cell-total": edits(entry=setting("cellCount", value=6)),
    "container/sector-counts/portal-total": edits(entry=setting("portalCount", value=5)),
}

CASES = HEADER | PADDING | JSON | VIEWS | TABLES | COUNTS

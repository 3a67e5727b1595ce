"""A case from a world and the changes that are made on the way from it to files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from casebuilder.coarse import Maker as CoarseMaker
from casebuilder.coarse import add_coarse
from casebuilder.container import glb_bytes, glb_parts, nav_bytes, nav_parts
from casebuilder.exact import cell_corners
from casebuilder.packets import Packet, Scene, Walks, packets
from casebuilder.proofs import Maker, proof_bytes, proof_parts
from casebuilder.state import State, Tables, sector_tables, world_states
from casebuilder.world import World

Json = dict[str, Any]
Files = dict[str, bytes]


@dataclass(frozen=True)
class Case:
    """A world, the changes made at each step, and what a validator is expected to say."""

    name: str
    world: World
    made: str
    catches: str
    requirement: str = ""
    """The one requirement that fails; empty when the case is valid or unreadable."""
    near: tuple[str, ...] = ()
    """Requirements whose limits a valid case only just keeps."""
    exit_status: int = 0
    states: Callable[[list[State]], object] | None = None
    """Changes states before digests, deltas and totals are made from them."""
    tables: Callable[[list[Tables]], object] | None = None
    """Changes the tables of the sectors before they are laid out."""
    nav_json: Callable[[Json, list[bytes]], object] | None = None
    """Changes the JSON part and the binary part (a list of one) of the first nav file."""
    nav: Callable[[bytes], bytes] | None = None
    """Changes the bytes of the first nav file."""
    proofs: Maker | None = None
    """Makes the certificate files; without it there is none."""
    cert_json: Callable[[Json, list[bytes]], object] | None = None
    """Changes the JSON part and the binary part (a list of one) of every certificate file."""
    cert: Callable[[bytes], bytes] | None = None
    """Changes the bytes of every certificate file before its digest is taken."""
    coarse: CoarseMaker | None = None
    """Makes coarse contents with face maps; without it there is none."""
    gltf: Callable[[Json, list[bytes]], object] | None = None
    """Changes the JSON and the binary chunk (a list of one) of content 0 before its digest is taken."""
    glb: Callable[[bytes], bytes] | None = None
    """Changes the bytes of content 0 before its digest is taken."""
    entry: Callable[[Json], object] | None = None
    """Changes the entry object."""
    tileset: Callable[[Json], object] | None = None
    """Changes the entry tileset."""
    files: Callable[[Files], object] | None = None
    """Changes the finished files, those of packets left aside."""
    packets: Walks | None = None
    """Sequences of packets by the name of their file."""
    packet: Callable[[list[Packet]], object] | None = None
    """Changes the packets of every sequence before they are laid out."""
    sequence: Callable[[bytes], bytes] | None = None
    """Changes the bytes of every sequence."""

    @property
    def folder(self) -> str:
        """Folder of the case below conformance/cases."""
        if self.requirement:
            return str(PurePosixPath("invalid") / self.requirement / self.name)
        return f"{'unreadable' if self.exit_status else 'valid'}/{self.name}"

    def description(self) -> Json:
        """Content of case.json."""
        status = 1 if self.requirement else self.exit_status
        expected: Json = {"tileset": "tileset.json"}
        if self.packets:
            expected["packets"] = list(self.packets)
        expected["exitStatus"] = status
        if self.requirement:
            expected["requirement"] = self.requirement
        if self.near:
            expected["nearMissOf"] = list(self.near)
        return {**expected, "made": self.made, "catches": self.catches}


def _box(points: list[tuple[float, ...]]) -> list[float]:
    low = [min(p[k] for p in points) for k in range(3)]
    high = [max(p[k] for p in points) for k in range(3)]
    centre = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
    half = [(b - a) / 2 for a, b in zip(low, high, strict=True)]
    return [*centre, half[0], 0.0, 0.0, 0.0, half[1], 0.0, 0.0, 0.0, half[2]]


def content_box(world: World, contents: set[int]) -> list[float]:
    """Smallest axis-aligned box of some contents, nav frame."""
    step = float(world.step)
    faces = [f for item in world.objects if item.content in contents for f in item.triangles]
    return _box([tuple(v * step for v in corner) for face in faces for corner in face])


def sector_box(world: World, first: int, count: int) -> list[float]:
    """Smallest axis-aligned box of the cells of a sector, nav frame."""
    step = float(world.step)
    corners = [c for cell in world.cells[first : first + count] for c in cell_corners(cell, world.exponent)]
    return _box([tuple(float(v) * step for v in c) for c in corners])


def content_name(content: int) -> str:
    """File name of a content of level 0."""
    return f"content/{content}.glb"


def nav_name(sector: int) -> str:
    """File name of a sector."""
    return f"nav/{sector}.nav"


def cert_name(sector: int) -> str:
    """File name of the certificates of a sector."""
    return f"nav/{sector}.cert"


def content_json(world: World, content: int, data: bytes) -> Json:
    """Content of a tile with its content object."""
    mine = [item for item in world.objects if item.content == content]
    facts: Json = {
        "contentId": content,
        "level": 0,
        "faceCount": sum(len(item.triangles) for item in mine),
        "objectCount": len(mine),
        "sha256": hashlib.sha256(data).hexdigest(),
    }
    flags = {
        "porous": [i for i, item in enumerate(mine) if item.porous],
        "oneSided": [i for i, item in enumerate(mine) if item.one_sided],
    }
    facts.update({name: indices for name, indices in flags.items() if indices})
    return {"uri": content_name(content), "extensions": {"3DTILES_nav": facts}}


def entry_object(world: World, states: list[State]) -> Json:
    """Object extensions.3DTILES_nav of the entry tileset."""
    boxes = [{"box": sector_box(world, first, count)} for first, count in world.sectors]
    limits = {} if world.max_range is None else {"visibility": {"maxRange": world.max_range}}
    return {
        "version": "0.1.0",
        "grid": {"exponent": world.exponent},
        "transform": list(world.transform),
        "clearance": world.clearance,
        "faceCount": len(world.faces),
        "objectCount": len(world.objects),
        "cellCount": len(world.cells),
        "portalCount": 2 * len(world.portals),
        "sectors": [
            {"uri": nav_name(i), "firstCell": first, "cellCount": count, "boundingVolume": boxes[i]}
            for i, (first, count) in enumerate(world.sectors)
        ],
        "lod": {
            "reference": world.lod.reference,
            "base": world.lod.base,
            "levelCount": world.lod.level_count,
        },
        "pvs": {"listed": sum(len(s.faces) for s in states), "provenVisible": sum(s.proven for s in states)},
        **limits,
        "provenance": {"encoder": "casebuilder 0.1.0", "parameters": {"seed": 0}, "coverage": 0.5},
    }


def entry_tileset(world: World, entry: Json, contents: list[Json]) -> Json:
    """Entry tileset: a root tile with the transform, and one child for each content."""
    children = [
        {"boundingVolume": {"box": content_box(world, {i})}, "geometricError": 0.0, "content": content}
        for i, content in enumerate(contents)
    ]
    return {
        "asset": {"version": "1.1"},
        "geometricError": 16.0,
        "extensionsUsed": ["3DTILES_nav"],
        "extensions": {"3DTILES_nav": entry},
        "root": {
            "transform": list(world.transform),
            "boundingVolume": {"box": content_box(world, set(range(len(contents))))},
            "geometricError": 16.0,
            "refine": "ADD",
            "children": children,
        },
    }


def _nav_file(case: Case, tables: Tables, sector: int) -> bytes:
    part, binary = nav_parts(tables, *case.world.sectors[sector])
    parts = [binary]
    if case.nav_json and sector == 0:
        case.nav_json(part, parts)
    data = nav_bytes(part, parts[0])
    return case.nav(data) if case.nav and sector == 0 else data


def _content_file(case: Case, content: int) -> bytes:
    gltf, binary = glb_parts(case.world, content)
    parts = [binary]
    if case.gltf and content == 0:
        case.gltf(gltf, parts)
    data = glb_bytes(gltf, parts[0])
    return case.glb(data) if case.glb and content == 0 else data


def _certificate_files(case: Case, states: list[State], entry: Json) -> Files:
    """Certificate files, of which the entry object then tells."""
    files = {}
    for sector, proofs in (case.proofs(case.world, states) if case.proofs else {}).items():
        part, binary = proof_parts(proofs)
        parts = [binary]
        if case.cert_json:
            case.cert_json(part, parts)
        data = proof_bytes(part, parts[0])
        name = cert_name(sector)
        files[name] = case.cert(data) if case.cert else data
        digest = hashlib.sha256(files[name]).hexdigest()
        entry["sectors"][sector]["certificates"] = {"uri": name, "sha256": digest}
    return files


def _packet_files(case: Case, scene: Scene, tileset: bytes) -> Files:
    """Sequences of packets for the finished tileset."""
    files = {}
    for name, steps in (case.packets or {}).items():
        made = packets(scene, hashlib.sha256(tileset).digest()[:8], steps)
        if case.packet:
            case.packet(made)
        data = b"".join(packet.layout() for packet in made)
        files[name] = case.sequence(data) if case.sequence else data
    return files


def json_bytes(value: object) -> bytes:
    """JSON file for people; lists of numbers stay on one line."""
    return _layout(value, "").encode() + b"\n"


def _layout(value: object, indent: str) -> str:
    inner = indent + "  "
    if isinstance(value, dict) and value:
        members = [f"{inner}{json.dumps(k)}: {_layout(v, inner)}" for k, v in value.items()]
        return "{\n" + ",\n".join(members) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(v, (dict, list)) for v in value):
        return "[\n" + ",\n".join(inner + _layout(v, inner) for v in value) + f"\n{indent}]"
    return json.dumps(value)


def assemble(case: Case) -> Files:
    """All files of a case by name, case.json included."""
    world = case.world
    states = world_states(world)
    if case.states:
        case.states(states)
    tables = [sector_tables(world, states, i) for i in range(len(world.sectors))]
    if case.tables:
        case.tables(tables)
    files = {nav_name(i): _nav_file(case, table, i) for i, table in enumerate(tables)}
    contents = sorted({item.content for item in world.objects})
    files |= {content_name(i): _content_file(case, i) for i in contents}
    entry = entry_object(world, states)
    files |= _certificate_files(case, states, entry)
    if case.entry:
        case.entry(entry)
    tileset = entry_tileset(world, entry, [content_json(world, i, files[content_name(i)]) for i in contents])
    coarse = case.coarse(world) if case.coarse else []
    files |= add_coarse(world, coarse, tileset)
    if case.tileset:
        case.tileset(tileset)
    files["tileset.json"] = json_bytes(tileset)
    if case.files:
        case.files(files)
    files |= _packet_files(case, Scene(world, states, coarse), files["tileset.json"])
    files["case.json"] = json_bytes(case.description())
    return files

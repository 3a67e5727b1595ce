"""Implicit tiling: bitstreams, addresses, subtrees of subtrees, both schemes and both refinements."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tileset_fixture import TRIANGLE, glb, model, subtree, tile, tileset, write

from tilesnav_ref.scene.tiles import read_tileset
from tilesnav_ref.scene.tiles.subtree import Shape, deinterleave

ALWAYS, NEVER = {"constant": 1}, {"constant": 0}


def at(*place: int) -> bytes:
    """A triangle whose first corner says where it is: (x, y, z) of the tile's axes."""
    x, y, z = place
    return glb(*model(TRIANGLE + np.array((x, z, -y))))


def tree(scheme: str, levels: int, depth: int, **members: Any) -> dict[str, Any]:
    names = "{level}/{x}/{y}" + ("/{z}" if scheme == "OCTREE" else "")
    tiling = {
        "subdivisionScheme": scheme,
        "availableLevels": levels,
        "subtreeLevels": depth,
        "subtrees": {"uri": f"s/{names}.subtree"},
    }
    return tileset(tile(f"c/{names}.glb", implicitTiling=tiling, **members))


def bits(length: int, *places: int) -> bytes:
    """A bitstream with ones at some places, the lowest bit of a byte first."""
    packed = bytearray((length + 7) // 8)
    for place in places:
        packed[place // 8] |= 1 << (place % 8)
    return bytes(packed)


def corners(path: Path) -> list[tuple[str, list[float]]]:
    return [(one.name, one.vertices[0].tolist()) for one in read_tileset(path, "auto", 1000).parts]


def test_quadtree_of_two_subtrees(tmp_path: Path) -> None:
    # Places of a subtree of two levels: 0 the root, then x + 2 y of its four. Subtrees below: 16, by the bits
    # x0, y0, x1, y1. The subtree at level 2, x 1, y 2 is number 1 + 8 = 9.
    top = subtree(
        {
            "tileAvailability": {"bitstream": 0},
            "contentAvailability": [{"bitstream": 1}],
            "childSubtreeAvailability": {"bitstream": 2},
        },
        [bits(5, 0, 2, 3), bits(5, 2, 4), bits(16, 9)],  # 4 has content and is not available
    )
    below = subtree(
        {
            "tileAvailability": ALWAYS,
            "contentAvailability": [{"bitstream": 0}],
            "childSubtreeAvailability": NEVER,
        },
        [bits(5, 0, 4)],
    )
    files = {
        "tileset.json": tree("QUADTREE", 4, 2),
        "s/0/0/0.subtree": top,
        "s/2/1/2.subtree": below,
        "c/1/1/0.glb": at(1, 0, 0),
        "c/2/1/2.glb": at(1, 2, 0),
        "c/3/3/5.glb": at(3, 5, 0),  # the last of the four: twice 1 and 2, and one more
    }
    assert corners(write(tmp_path, files)) == [
        ("c/1/1/0.glb", [1, 0, 0]),
        ("c/2/1/2.glb", [1, 2, 0]),
        ("c/3/3/5.glb", [3, 5, 0]),
    ]


def test_octree_with_json_subtrees_and_a_buffer_file(tmp_path: Path) -> None:
    # Places of a subtree of two levels: 0 the root, then x + 2 y + 4 z of its eight.
    text = {
        "buffers": [{"uri": "bits.bin", "byteLength": 2}],
        "bufferViews": [{"buffer": 0, "byteLength": 2}],
        "tileAvailability": ALWAYS,
        "contentAvailability": [{"bitstream": 0}],
        "childSubtreeAvailability": NEVER,
    }
    files = {
        "tileset.json": tree("OCTREE", 2, 2),
        "s/0/0/0/0.subtree": text,
        "s/0/0/0/bits.bin": bits(9, 2, 6, 8),
        "c/1/1/0/0.glb": at(1, 0, 0),
        "c/1/1/0/1.glb": at(1, 0, 1),
        "c/1/1/1/1.glb": at(1, 1, 1),
    }
    assert [corner for _, corner in corners(write(tmp_path, files))] == [[1, 0, 0], [1, 0, 1], [1, 1, 1]]


@pytest.mark.parametrize(
    ("refine", "kept"),
    [("ADD", ["0/0/0", "1/0/0", "1/1/1", "2/1/1"]), ("REPLACE", ["1/1/1", "2/1/1"])],
)
def test_refinement(refine: str, kept: list[str], tmp_path: Path) -> None:
    # Level 2 starts at place 5; x 1, y 1 is number 3 there. It lies in 1/0/0, and all lie in 0/0/0.
    one = {
        "tileAvailability": ALWAYS,
        "contentAvailability": [{"bitstream": 0}],
        "childSubtreeAvailability": NEVER,
    }
    files = {
        "tileset.json": tree("QUADTREE", 3, 3, refine=refine),
        "s/0/0/0.subtree": subtree(one, [bits(21, 0, 1, 4, 5 + 3)]),
        "c/0/0/0.glb": at(0, 0, 0),
        "c/1/0/0.glb": at(0, 0, 0),
        "c/1/1/1.glb": at(1, 1, 0),
        "c/2/1/1.glb": at(1, 1, 0),
    }
    assert [name[2:-4] for name, _ in corners(write(tmp_path, files))] == kept


def test_the_tree_ends_at_its_last_level(tmp_path: Path) -> None:
    every = {"tileAvailability": ALWAYS, "contentAvailability": [ALWAYS], "childSubtreeAvailability": ALWAYS}
    files = {
        "tileset.json": tree("QUADTREE", 1, 2),
        "s/0/0/0.subtree": subtree(every),
        "c/0/0/0.glb": at(7, 0, 0),
    }
    assert corners(write(tmp_path, files)) == [("c/0/0/0.glb", [7, 0, 0])]


def test_several_contents_and_the_transform_of_the_root(tmp_path: Path) -> None:
    entry = tree("QUADTREE", 1, 1, transform=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 50, 1])
    entry["root"]["contents"] = [entry["root"].pop("content"), {"uri": "d/{level}-{x}-{y}.glb"}]
    some = {
        "tileAvailability": ALWAYS,
        "contentAvailability": [NEVER, ALWAYS],
        "childSubtreeAvailability": NEVER,
    }
    files = {"tileset.json": entry, "s/0/0/0.subtree": subtree(some), "d/0-0-0.glb": at(2, 3, 4)}
    assert corners(write(tmp_path, files)) == [("d/0-0-0.glb", [2, 3, 54])]


def test_morton_numbers_against_bit_by_bit_text() -> None:
    for dimensions, level in ((2, 5), (3, 4)):
        index = np.arange(1 << (dimensions * level))
        found = deinterleave(index, dimensions, level)
        for number in range(0, len(index), 37):
            digits = format(number, f"0{dimensions * level}b")[::-1]
            expected = [int(digits[axis::dimensions][::-1], 2) for axis in range(dimensions)]
            assert found[number].tolist() == expected


def test_places_of_a_subtree() -> None:
    assert (Shape(2, 3).nodes, Shape(2, 3).roots_below, Shape(2, 3).first(2)) == (1 + 4 + 16, 64, 5)
    assert (Shape(3, 2).nodes, Shape(3, 2).roots_below, Shape(3, 2).first(1)) == (9, 64, 1)

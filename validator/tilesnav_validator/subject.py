"""What is being judged, built piece by piece as the checks find it sound."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import (
    certfile,
    facemaps,
    glb,
    lodjudge,
    packets,
    polyhedra,
    strictjson,
    tables,
    tiles,
)
from tilesnav_validator.files import FileError, Folder, UriOutsideError, open_file
from tilesnav_validator.findings import Finding, Settings, UnreadableInputError
from tilesnav_validator.navfile import NavFile

if TYPE_CHECKING:
    from tilesnav_validator.packetjudge import Followed

TOLERANCE_IN_STEPS = 2.0**-6
"""Tolerance of geometric tests in grid steps. float64 planes within 2^13 m of the origin are off by less
than 2^-39 m; with the smallest step, 2^-20 m, this is 2^13 times more, and it is far below the step
itself."""


def position_numbers(grid: NDArray[np.int64]) -> NDArray[np.int64]:
    """Number the positions of corners, equal ones alike: shape (f, 3), from grid steps, shape (f, 3, 3)."""
    x, y, z = (grid.reshape(-1, 3) + 2**23).T
    _, first = np.unique((x << 24) | y, return_inverse=True)  # two keys, as three times 24 bits do not fit 64
    _, number = np.unique((first.astype(np.int64) << 24) | z, return_inverse=True)
    return number.astype(np.int64).reshape(-1, 3)


@dataclass(frozen=True)
class Faces:
    """Every face of level 0.

    Attributes
    ----------
    grid : ndarray of int64, shape (f, 3, 3)
        Vertices in grid steps, nav frame; exact.
    points : ndarray of float64, shape (f, 3, 3)
        Vertices in metres; exact too.
    objects : ndarray of int64, shape (f,)
        Object that each face belongs to.
    porous_objects : ndarray of int64
        Objects whose faces hide nothing.
    one_sided_objects : ndarray of int64
        Objects whose faces are seen from their front only.
    """

    grid: NDArray[np.int64]
    points: NDArray[np.float64]
    objects: NDArray[np.int64]
    porous_objects: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    one_sided_objects: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    @cached_property
    def sound(self) -> NDArray[np.bool_]:
        """Faces that are not degenerate, shape (f,); exact, since differences fit 24 bits and products 50."""
        edges = self.grid[:, 1:] - self.grid[:, :1]
        return np.asarray((np.cross(edges[:, 0], edges[:, 1]) != 0).any(axis=1))

    @cached_property
    def blocking(self) -> NDArray[np.bool_]:
        """Faces that hide what is behind them, shape (f,): neither degenerate nor porous."""
        return np.asarray(self.sound & ~np.isin(self.objects, self.porous_objects))

    @cached_property
    def one_sided(self) -> NDArray[np.bool_]:
        """Faces that are seen from their front only, shape (f,)."""
        return np.isin(self.objects, self.one_sided_objects)

    @cached_property
    def corner_numbers(self) -> NDArray[np.int64]:
        """For each corner of each face the number of its position, shape (f, 3)."""
        return position_numbers(self.grid)


def _sequence(path: Path) -> packets.Sequence:
    """The packets of a file that is named by whoever asks for a verdict on it."""
    try:
        return packets.read(path.name, open_file(path))
    except FileError as error:
        raise UnreadableInputError(f"{path}: {error}") from None


class Subject:
    """A tileset and what has been read of it.

    Parameters
    ----------
    path : Path
        The entry tileset.
    settings : Settings

    Raises
    ------
    UnreadableInputError
        If the entry tileset cannot be opened or is not a JSON object, or a file of packets cannot be opened.
    """

    def __init__(self, path: Path, settings: Settings) -> None:
        self.settings = settings
        real = Path(os.path.realpath(path))
        self.folder = Folder(real.parent)
        self.entry_name = real.name
        try:
            data = open_file(real)
            self.entry = tiles.read_tileset(data)
        except (FileError, strictjson.JsonError) as error:
            raise UnreadableInputError(f"{path}: {error}") from None
        self.map = hashlib.sha256(data).digest()[:8]
        self.sequences = [_sequence(name) for name in settings.packets]
        self.followed: Followed | None = None
        self.walk = tiles.walk(self.folder, (real.name,), self.entry)
        self._unsound_cells: set[int] = set()
        self.search: dict[str, Any] = {}
        self.proof: dict[str, Any] = {}

    @property
    def nav(self) -> dict[str, Any]:
        """The entry object; sound after the stage ``schema``."""
        found: dict[str, Any] = self.entry["extensions"][tiles.EXTENSION]
        return found

    @property
    def step(self) -> float:
        """Grid step in metres."""
        return float(2.0 ** int(self.nav["grid"]["exponent"]))

    @property
    def tolerance(self) -> float:
        """Tolerance of geometric tests in metres."""
        return self.step * TOLERANCE_IN_STEPS

    def number(self, name: str) -> int:
        """A count of the entry object."""
        return int(self.nav[name])

    @cached_property
    def sector_faults(self) -> dict[str, list[Finding]]:
        """Faults of opening the sectors, by requirement; filled by ``sectors``."""
        links = ("core/sector-resolves", "certificate/file-resolves", "level/face-map-resolves")
        return {identifier: [] for identifier in ("core/uri-inside", *links)}

    @cached_property
    def sectors(self) -> list[NavFile]:
        """The nav files that could be opened, in the order of the list."""
        opened = []
        for index, sector in enumerate(self.nav["sectors"]):
            found = self._open(sector["uri"], self._where(f"sectors/{index}/uri"), "core/sector-resolves")
            if found:
                opened.append(NavFile(*found))
        return opened

    @cached_property
    def certificate_files(self) -> dict[int, NavFile]:
        """The certificate files that could be opened and have their digest, by the number of the sector."""
        opened = {}
        for index, sector in enumerate(self.nav["sectors"]):
            if "certificates" not in sector:
                continue
            uri, stated = sector["certificates"]["uri"], sector["certificates"]["sha256"]
            place = f"sectors/{index}/certificates"
            found = self._open(uri, self._where(f"{place}/uri"), "certificate/file-resolves")
            if found:
                digest = hashlib.sha256(found[1]).hexdigest()
                if digest == stated:
                    opened[index] = NavFile(*found, certfile.CERT)
                else:
                    self.sector_faults["certificate/file-resolves"].append(
                        Finding(self._where(f"{place}/sha256"), stated[:80], digest)
                    )
        return opened

    @cached_property
    def certificates(self) -> dict[int, certfile.Certificates]:
        """Certificates by the number of the sector; only after the check of their containers."""
        return {index: certfile.read(file) for index, file in self.certificate_files.items()}

    def _where(self, pointer: str) -> str:
        return f"{self.entry_name}#/extensions/{tiles.EXTENSION}/{pointer}"

    @cached_property
    def coarse(self) -> list[facemaps.Coarse]:
        """Nav contents of level 1 or more whose face map could be opened and has its digest."""
        opened = []
        for content in self.walk.contents:
            stated = content.nav.get("faceMap")
            if content.nav["level"] == 0 or stated is None:
                continue
            where = f"{content.place}/extensions/{tiles.EXTENSION}/faceMap"
            found = self._open(stated["uri"], f"{where}/uri", "level/face-map-resolves", content.folder)
            if not found:
                continue
            digest = hashlib.sha256(found[1]).hexdigest()
            if digest == stated["sha256"]:
                opened.append(facemaps.Coarse(content, NavFile(*found, facemaps.FMAP)))
            else:
                finding = Finding(f"{where}/sha256", stated["sha256"][:80], digest)
                self.sector_faults["level/face-map-resolves"].append(finding)
        return opened

    @cached_property
    def face_maps(self) -> list[facemaps.FaceMap]:
        """Face map of each content of ``coarse``; only after the check of their containers."""
        return [facemaps.read(coarse.file) for coarse in self.coarse]

    @cached_property
    def coarse_primitives(self) -> list[list[glb.Primitive]]:
        """Primitives of each content of ``coarse``; only after the check of these contents."""
        return [glb.read(coarse.content.data) for coarse in self.coarse if coarse.content.data is not None]

    def _open(
        self, uri: str, where: str, requirement: str, base: tuple[str, ...] = ()
    ) -> tuple[str, memoryview] | None:
        """Name and bytes of a file; None, and a fault noted, where it cannot be opened."""
        try:
            place = self.folder.resolve(base, uri)
            return "/".join(place), open_file(self.folder.path(place))
        except UriOutsideError as error:
            allowed = "a relative reference inside the folder of the entry tileset"
            finding = Finding(where, f"{uri[:200]!r} {error}", allowed)
            self.sector_faults["core/uri-inside"].append(finding)
        except FileError as error:
            finding = Finding(where, f"{uri[:200]!r}: {error}", "a readable file")
            self.sector_faults[requirement].append(finding)
        return None

    @cached_property
    def finest(self) -> list[tiles.Content]:
        """Nav contents of level 0 in the order of ``contentId``."""
        contents = [content for content in self.walk.contents if content.nav["level"] == 0]
        return sorted(contents, key=lambda content: int(content.nav["contentId"]))

    @cached_property
    def primitives(self) -> list[list[glb.Primitive]]:
        """Primitives of each content of ``finest``; raises ``GlbError`` where one is not as it should be."""
        return [glb.read(content.data) for content in self.finest if content.data is not None]

    @cached_property
    def faces(self) -> Faces:
        """All faces; only after the checks of the contents."""
        points = [part.positions[part.triangles] for content in self.primitives for part in content]
        counts = [len(part) for part in points]
        joined = np.concatenate([np.zeros((0, 3, 3)), *points])
        grid = np.rint(joined / self.step).astype(np.int64)
        objects = np.repeat(np.arange(len(counts), dtype=np.int64), counts)
        return Faces(grid, joined, objects, self._flagged("porous"), self._flagged("oneSided"))

    def _flagged(self, member: str) -> NDArray[np.int64]:
        """Numbers of the objects that a member of the content objects names."""
        numbers: list[int] = []
        first = 0
        for content, primitives in zip(self.finest, self.primitives, strict=True):
            numbers += [first + int(index) for index in content.nav.get(member, [])]
            first += len(primitives)
        return np.array(numbers, dtype=np.int64)

    @property
    def max_range(self) -> float | None:
        """Metres within which a face counts as visible; None for any distance."""
        limits = self.nav.get("visibility")
        return None if limits is None else float(limits["maxRange"])

    @cached_property
    def tables(self) -> tables.Tables:
        """Tables of all sectors; only after the checks of the containers."""
        return tables.join(self.sectors)

    @cached_property
    def polyhedra(self) -> polyhedra.Polyhedra:
        """Vertices and facets of all cells; only after the checks of the planes."""
        return polyhedra.build(self.tables.planes, self.tolerance)

    @cached_property
    def levels(self) -> lodjudge.Levels:
        """Judgement of the level codes of the cells that are sound when it is first asked for."""
        sound, lod = self.sound_cells, self.nav["lod"]
        cells = lodjudge.pick_cells(self.tables, sound, self.settings.lod_pairs, self.settings.seed)
        scale = lodjudge.Scale(float(lod["reference"]), float(lod["base"]), int(lod["levelCount"]))
        scene = lodjudge.Scene(
            self.polyhedra.corners, self.faces.points, self.faces.objects, self.faces.sound
        )
        coarse, wasteful, *undecided = lodjudge.judge(self.tables, scene, scale, cells)
        return lodjudge.Levels(coarse, wasteful, len(cells), int(sound.sum()), *undecided)

    def reject_cell(self, cell: int | np.integer[Any]) -> None:
        """Leave a cell out of every later check."""
        self._unsound_cells.add(int(cell))

    @property
    def sound_cells(self) -> NDArray[np.bool_]:
        """Cells that no check has found fault with, shape (n,)."""
        sound = np.ones(self.tables.cell_count, dtype=bool)
        sound[list(self._unsound_cells)] = False
        return sound

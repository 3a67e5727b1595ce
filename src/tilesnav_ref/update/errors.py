"""Why an earlier tileset cannot be brought up to date."""

from __future__ import annotations

from tilesnav_ref.stream.errors import TilesetError


class UpdateError(TilesetError):
    """An earlier tileset that can be read and does not go with this run: file, place, found, allowed."""

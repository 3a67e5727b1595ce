"""3D Tiles tilesets as scene input: versions 1.0 and 1.1, explicit, external and implicit."""

from tilesnav_ref.scene.tiles.place import place
from tilesnav_ref.scene.tiles.tileset import read_tileset

__all__ = ["place", "read_tileset"]

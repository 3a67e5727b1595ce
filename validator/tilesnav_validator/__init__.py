"""Independent validator of the 3D Tiles extension 3DTILES_nav."""

__version__ = "0.1.0"

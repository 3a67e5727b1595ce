"""What can go wrong while a tileset is made."""

from __future__ import annotations


class EncodeError(ValueError):
    """The input was read, but no tileset can be made of it."""


class OutputError(ValueError):
    """The place where the tileset is to go cannot be used."""

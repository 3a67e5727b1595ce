"""What packets carry, and what is wrong with one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


class PacketError(ValueError):
    """A packet that cannot be decoded, or that does not fit what the client holds."""


@dataclass(frozen=True)
class ObjectFaces:
    """The faces of one level of an object that a client holds.

    Notes
    -----
    The corners of a face start with the least of its three rotations, compared coordinate by coordinate; the
    orientation is kept.
    """

    object: int
    """Number of the object, 0 or more, below 2**32."""
    level: int
    """0 (finest) to 255."""
    flags: int
    """0 to 255."""
    faces: NDArray[np.uint32]
    """(F,) ascending face numbers within the level of the object."""
    corners: NDArray[np.int32]
    """(F, 3, 3) grid coordinates of magnitude below 2**23, nav frame."""


@dataclass(frozen=True)
class Limits:
    """What a decoder accepts at most."""

    faces: int = 1 << 18
    """Faces that a packet brings. A decoder takes up to 600 bytes for each before it has read them."""
    objects: int = 1 << 16
    """Objects that the client holds afterwards."""

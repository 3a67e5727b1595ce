"""What a client holds for the cell that it is in, and how it follows deltas."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.errors import DeltaError

Numbers = NDArray[np.uint32]
Codes = NDArray[np.uint8]


@dataclass(frozen=True)
class Delta:
    """The change behind one directed portal; every list ascends."""

    entered: Numbers
    """Faces of the target's set that the source's lacks."""
    left: Numbers
    """Faces of the source's set that the target's lacks."""
    switch_objects: Numbers
    """Objects that the target lists with another code than the source, or that the source does not list."""
    switch_codes: Codes
    """Their codes in the target."""


@dataclass(frozen=True)
class State:
    """Faces, visible objects and level codes of a cell; faces and objects ascend."""

    faces: Numbers
    objects: Numbers
    codes: Codes
    """Parallel to objects."""

    def canonical_bytes(self) -> bytes:
        """Faces, objects and codes, little-endian: the first two u32 behind their count, the codes u8."""
        return b"".join(
            (
                len(self.faces).to_bytes(4, "little"),
                self.faces.astype("<u4").tobytes(),
                len(self.objects).to_bytes(4, "little"),
                self.objects.astype("<u4").tobytes(),
                self.codes.astype("u1").tobytes(),
            )
        )

    def digest(self) -> bytes:
        """SHA-256 of the canonical bytes."""
        return hashlib.sha256(self.canonical_bytes()).digest()


def apply_delta(state: State, delta: Delta, object_offsets: NDArray[np.int64]) -> State:
    """Follow a directed portal.

    Parameters
    ----------
    state : State
        Of the cell on this side.
    delta : Delta
        Of the portal.
    object_offsets : (K + 1,) int64
        First face of every object, and the number of faces: object k has the faces from object_offsets[k] to
        object_offsets[k + 1] - 1.

    Returns
    -------
    State
        Of the cell behind.

    Raises
    ------
    DeltaError
        When a face that leaves is not there, one that enters is there already, or an object that is visible
        then has no code: the state is not that of the portal's source.
    """
    if not np.isin(delta.left, state.faces, assume_unique=True).all():
        raise DeltaError("a face leaves that the state does not hold")
    if np.isin(delta.entered, state.faces, assume_unique=True).any():
        raise DeltaError("a face enters that the state holds already")
    kept = np.setdiff1d(state.faces, delta.left, assume_unique=True)
    faces = np.union1d(kept, delta.entered).astype(np.uint32)
    objects, codes = _switched(state, delta)
    visible = np.unique(np.searchsorted(object_offsets, faces, side="right") - 1)
    places = np.searchsorted(objects, visible)
    if len(visible) and (places[-1] >= len(objects) or np.any(objects[places] != visible)):
        raise DeltaError("an object becomes visible without a level code")
    return State(faces, objects[places], codes[places])


def _switched(state: State, delta: Delta) -> tuple[Numbers, Codes]:
    objects = np.union1d(state.objects, delta.switch_objects).astype(np.uint32)
    codes = np.zeros(len(objects), dtype=np.uint8)
    codes[np.searchsorted(objects, state.objects)] = state.codes
    codes[np.searchsorted(objects, delta.switch_objects)] = delta.switch_codes
    return objects, codes

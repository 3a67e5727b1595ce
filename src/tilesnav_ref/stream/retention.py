"""What a vehicle goes on holding beyond what a cell calls for, so that it need not be sent again."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tilesnav_ref.packet.model import ObjectFaces
from tilesnav_ref.packet.state import Parts


def union(one: ObjectFaces, other: ObjectFaces) -> ObjectFaces:
    """Faces of either of two parts of one object at one level."""
    faces, places = np.unique(np.concatenate((one.faces, other.faces)), return_index=True)
    corners = np.concatenate((one.corners, other.corners))[places]
    return ObjectFaces(one.object, one.level, one.flags, faces, corners)


def new_faces(part: ObjectFaces, held: ObjectFaces | None) -> int:
    """Count the faces of a part that have to be sent to a vehicle that holds another part of the object."""
    if held is None or (held.level, held.flags) != (part.level, part.flags):
        return len(part.faces)
    return len(part.faces) - int(np.isin(part.faces, held.faces, assume_unique=True).sum())


def choose_finer(needed: Parts, finer: Parts, held: Parts, budget: int) -> Parts:
    """Take objects at the finer level at which they are held, where that costs fewer new faces.

    Parameters
    ----------
    needed : tuple of ObjectFaces
        What the cell calls for at the levels that are wanted.
    finer : tuple of ObjectFaces
        What it calls for of some of these objects at the finer levels at which they are held.
    held : tuple of ObjectFaces
        What the vehicle holds.
    budget : int
        Faces by which the result may be larger than `needed`.

    Returns
    -------
    tuple of ObjectFaces
        One for each object of `needed`. Those that save most come first where the budget does not do for all.
    """
    chosen = {part.object: part for part in needed}
    holds = {part.object: part for part in held}
    saved = {
        part.object: len(chosen[part.object].faces) - new_faces(part, holds[part.object]) for part in finer
    }
    for part in sorted(finer, key=lambda part: (-saved[part.object], part.object)):
        cost = len(part.faces) - len(chosen[part.object].faces)
        if saved[part.object] > 0 and cost <= budget:
            chosen[part.object] = part
            budget -= cost
    return tuple(chosen[number] for number in sorted(chosen))


def retained(required: Parts, held: Parts, last_needed: Mapping[int, int], budget: int) -> Parts:
    """Add to what has to be held what is held already, as far as a budget goes.

    Parameters
    ----------
    required : tuple of ObjectFaces
        What the cell calls for, at the levels at which it is to be held.
    held : tuple of ObjectFaces
        What the vehicle holds.
    last_needed : mapping
        When each held object was last called for, as a number that grows.
    budget : int
        Faces that may be added.

    Returns
    -------
    tuple of ObjectFaces
        Every face of `required`, and more faces of the same objects at the same level, and other objects.
        The objects needed most recently stay; one that does not fit goes, though a smaller one that was
        needed before it may stay. An object of `required` that is held at another level is not held at both.
    """
    result = {part.object: part for part in required}
    # Objects that the cell calls for were needed later than any other.
    order = sorted(held, key=lambda part: (part.object not in result, -last_needed[part.object], part.object))
    for part in order:
        mine = result.get(part.object)
        if mine is None:
            kept = part
        elif (mine.level, mine.flags) == (part.level, part.flags):
            kept = union(mine, part)
        else:
            continue
        cost = len(kept.faces) - (0 if mine is None else len(mine.faces))
        if cost <= budget:
            result[part.object] = kept
            budget -= cost
    return tuple(result[number] for number in sorted(result))

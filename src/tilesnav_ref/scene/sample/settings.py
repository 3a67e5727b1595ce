"""Settings of the sample town."""

from __future__ import annotations

from dataclasses import dataclass

from tilesnav_ref.scene.errors import SceneError

METRE = 1024
"""Grid steps of a metre, at the default grid exponent of -10."""

UNIT = METRE // 16
"""Every plan coordinate is a multiple of it, so that slopes of a multiple of 1/64 have heights on the
grid."""

DETAILS = ("coarse", "median", "fine")

BLOCK_PITCH = 25
"""Metres from the middle of one street to the middle of the next."""


@dataclass(frozen=True)
class TownSettings:
    """A town for training, after the site that the paper flew at: about 10,000 square metres of ground.

    Notes
    -----
    The plan depends on the seed and the size only; the detail changes walls and windows, not where houses
    are. The default is a quarter of the site, coarse, for quick runs; `TRAINING_SITE` is all of it.
    """

    seed: int = 0
    detail: str = "coarse"
    """About 50 (coarse), 250 (median) or 1000 (fine) faces a building."""
    width: int = 50
    """Metres along x, a multiple of 25."""
    depth: int = 50
    """Metres along y, a multiple of 25."""
    sloped: bool = False
    """Whether the ground rises and falls from street to street."""

    def __post_init__(self) -> None:
        """Check every setting.

        Raises
        ------
        SceneError
            Naming the setting.
        """
        if self.detail not in DETAILS:
            raise SceneError("town settings", "detail", repr(self.detail), ", ".join(DETAILS))
        if self.seed < 0:
            raise SceneError("town settings", "seed", repr(self.seed), "0 or more")
        for name, value in (("width", self.width), ("depth", self.depth)):
            if value % BLOCK_PITCH or not BLOCK_PITCH <= value <= 1000:
                raise SceneError(
                    "town settings", name, repr(value), "a multiple of 25, from 25 to 1000 metres"
                )


TRAINING_SITE = TownSettings(detail="fine", width=100, depth=100)
"""The whole site at full detail, about 70,000 faces."""

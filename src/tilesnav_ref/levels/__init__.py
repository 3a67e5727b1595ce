"""Coarse levels of the scene: fewer faces, a measured error, and which faces stand for which."""

from tilesnav_ref.levels.model import LEVELS_MAX, CoarseLevel, LevelSettings
from tilesnav_ref.levels.simplify import coarse_levels

__all__ = ["LEVELS_MAX", "CoarseLevel", "LevelSettings", "coarse_levels"]

"""Level of detail from a region: the largest L(phi, d) = cos(phi) / d between a cell and an object."""

from tilesnav_ref.lod.codes import level_codes, thresholds
from tilesnav_ref.lod.levels import choose_levels
from tilesnav_ref.lod.maximum import largest_level, region_maximum
from tilesnav_ref.lod.model import LodSettings, LodTable

__all__ = [
    "LodSettings",
    "LodTable",
    "choose_levels",
    "largest_level",
    "level_codes",
    "region_maximum",
    "thresholds",
]

"""The sample scene: a town with houses, courtyards, arcades and a tower, exact on the grid."""

from tilesnav_ref.scene.sample.settings import DETAILS, TRAINING_SITE, TownSettings
from tilesnav_ref.scene.sample.town import make_town

__all__ = ["DETAILS", "TRAINING_SITE", "TownSettings", "make_town"]

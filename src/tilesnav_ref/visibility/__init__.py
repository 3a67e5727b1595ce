"""From-region visibility that is conservative by proof."""

from tilesnav_ref.visibility.engine import compute_pvs, forget_work
from tilesnav_ref.visibility.model import PvsTable
from tilesnav_ref.visibility.settings import VisibilitySettings

__all__ = ["PvsTable", "VisibilitySettings", "compute_pvs", "forget_work"]

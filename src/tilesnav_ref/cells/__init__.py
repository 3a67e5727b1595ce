"""Free space as navigation cells: prisms and boxes with exactly six planes, and the portals between them."""

from tilesnav_ref.cells.decomposition import decompose
from tilesnav_ref.cells.model import KIND_AERIAL, KIND_GROUND, CellComplex
from tilesnav_ref.cells.planes import planes
from tilesnav_ref.cells.settings import CellError, CellSettings

__all__ = ["KIND_AERIAL", "KIND_GROUND", "CellComplex", "CellError", "CellSettings", "decompose", "planes"]

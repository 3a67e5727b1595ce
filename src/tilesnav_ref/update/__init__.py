"""A changed scene: what an earlier tileset says about cells that see nothing of the change is taken over."""

from tilesnav_ref.update.changes import Update, find_changes
from tilesnav_ref.update.errors import UpdateError
from tilesnav_ref.update.previous import Previous, open_previous

__all__ = ["Previous", "Update", "UpdateError", "find_changes", "open_previous"]

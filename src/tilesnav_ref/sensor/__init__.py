"""A simulated LiDAR: scans of a scene along a route, with the truth about each point."""

from tilesnav_ref.sensor.errors import ScanError
from tilesnav_ref.sensor.model import NO_FACE, Returns, Scan, join
from tilesnav_ref.sensor.route import Route
from tilesnav_ref.sensor.settings import ScannerSettings
from tilesnav_ref.sensor.simulate import scan_count, simulate_scans
from tilesnav_ref.sensor.write import write_scans

__all__ = [
    "NO_FACE",
    "Returns",
    "Route",
    "Scan",
    "ScanError",
    "ScannerSettings",
    "join",
    "scan_count",
    "simulate_scans",
    "write_scans",
]

"""Point clouds: readers and made-up towns."""

from tilesnav_ref.clouds.model import Chunk, PointCloud
from tilesnav_ref.clouds.read import OPENERS, cloud_chunks, read_cloud
from tilesnav_ref.clouds.settings import CloudSettings

__all__ = ["OPENERS", "Chunk", "CloudSettings", "PointCloud", "cloud_chunks", "read_cloud"]

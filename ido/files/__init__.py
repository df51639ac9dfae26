"""Files of clouds: read whole or refused, written whole or not at all (docs/files.md)."""

from ido.files.cloud_file import CloudFile, UsedPoints, used_points
from ido.files.loading import READERS, load_cloud, open_cloud, read_cloud
from ido.files.saving import save_cloud

__all__ = [
    "READERS",
    "CloudFile",
    "UsedPoints",
    "load_cloud",
    "open_cloud",
    "read_cloud",
    "save_cloud",
    "used_points",
]

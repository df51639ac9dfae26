"""What people use today instead: registration by public libraries, with their own code.

Each has two named settings: `default`, the library's own or its tutorial's, and `tuned`, chosen on scenes of their own
by `ido experiment tune`. Open3D comes with this program; the others need `pip install 'ido-explorer[peers]'`.
"""

from ido.peers.fpfh import FGR, RANSAC
from ido.peers.gicp import GICP
from ido.peers.kiss import KISS
from ido.peers.peer import Found, Peer, PeerError

__all__ = ["FGR", "GICP", "KISS", "RANSAC", "Found", "Peer", "PeerError"]

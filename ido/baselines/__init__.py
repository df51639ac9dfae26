"""The methods that the paper compares DO with. Each moves the scene onto the model from where it lies.

Every method has two named settings: `default`, as its authors ship it (but without scale; for KCCE, of which nothing is
public, our own), and `tuned`, chosen on scenes of their own by `ido experiment tune`.
"""

from ido.baselines.baseline import Baseline
from ido.baselines.cpd import BCPD, CPD
from ido.baselines.gmmreg import GMMReg
from ido.baselines.icp import ICP
from ido.baselines.kcce import KCCE
from ido.baselines.nothing import Nothing

__all__ = ["BCPD", "CPD", "ICP", "KCCE", "Baseline", "GMMReg", "Nothing"]

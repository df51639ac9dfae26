"""Open3D's global registration: matches of FPFH features, then RANSAC or FGR (Zhou et al. 2016), then ICP.

The steps, and the settings by default, are those of Open3D's tutorial.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ido.one_thread import on_one_processor
from ido.peers.peer import Finder, Found, Peer
from ido.registration import StopReason
from ido.types import DoubleArray, FloatArray

_NORMAL_NEIGHBOURS, _FEATURE_NEIGHBOURS = 30, 100
_SEED = 0


@dataclass(frozen=True, kw_only=True)
class FPFHPeer(Peer):
    """Both clouds are thinned, get normals and features, and are matched; ICP, point to plane, ends it.

    Args:
        voxel: clouds are thinned to a point for each cube of this side.
        normal_gain: normals are those of the neighbours within so many voxels.
        feature_gain: features are those of the neighbours within so many voxels.
        distance_gain: matches up to so many voxels count.
        refine_gain: matches of ICP up to so many voxels count.
    """

    package: ClassVar[str] = "open3d"
    voxel: float = 0.05
    normal_gain: float = 2.0
    feature_gain: float = 5.0
    distance_gain: float
    refine_gain: float = 0.4

    @abstractmethod
    def match(self, o3d: Any, scene: Any, model: Any, scene_features: Any, model_features: Any) -> Any:
        """Open3D's result of matching features."""

    def onto(self, cloud: FloatArray) -> Finder:
        with on_one_processor():
            o3d = self.library()
        model, model_features = self._described(o3d, cloud.astype(np.float64))
        registration = o3d.pipelines.registration
        plane = registration.TransformationEstimationPointToPlane()

        def find(points: DoubleArray) -> Found:
            o3d.utility.random.seed(_SEED)
            scene, features = self._described(o3d, points)
            with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):  # few matches are no news
                matched = self.match(o3d, scene, model, features, model_features)
            reach = self.refine_gain * self.voxel
            refined = registration.registration_icp(scene, model, reach, matched.transformation, plane)
            stop = StopReason.CONVERGED if matched.fitness > 0 else StopReason.NOTHING_NEAR
            return np.array(refined.transformation), stop

        return find

    def _described(self, o3d: Any, points: DoubleArray) -> tuple[Any, Any]:
        """A thinned cloud with normals, and its features."""
        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points)).voxel_down_sample(self.voxel)
        near = o3d.geometry.KDTreeSearchParamHybrid
        cloud.estimate_normals(near(self.normal_gain * self.voxel, _NORMAL_NEIGHBOURS))
        feature_reach = near(self.feature_gain * self.voxel, _FEATURE_NEIGHBOURS)
        return cloud, o3d.pipelines.registration.compute_fpfh_feature(cloud, feature_reach)


@dataclass(frozen=True, kw_only=True)
class RANSAC(FPFHPeer):
    """Poses of three matches at a time, of which the one with the most matches near it wins.

    Args:
        max_iterations: poses to try.
        confidence: it stops once the best pose is that probable.
        similarity: edges between matches are at least that alike.
    """

    title: ClassVar[str] = "Open3D RANSAC"
    distance_gain: float = 1.5
    max_iterations: int = 100_000
    confidence: float = 0.999
    similarity: float = 0.9

    def match(self, o3d: Any, scene: Any, model: Any, scene_features: Any, model_features: Any) -> Any:
        registration, reach = o3d.pipelines.registration, self.distance_gain * self.voxel
        return registration.registration_ransac_based_on_feature_matching(
            scene,
            model,
            scene_features,
            model_features,
            mutual_filter=True,
            max_correspondence_distance=reach,
            ransac_n=3,
            checkers=[
                registration.CorrespondenceCheckerBasedOnEdgeLength(self.similarity),
                registration.CorrespondenceCheckerBasedOnDistance(reach),
            ],
            criteria=registration.RANSACConvergenceCriteria(self.max_iterations, self.confidence),
        )


@dataclass(frozen=True, kw_only=True)
class FGR(FPFHPeer):
    """Fast global registration: all matches at once, with a robust cost.

    Args:
        max_iterations: of the optimisation.
    """

    title: ClassVar[str] = "Open3D FGR"
    distance_gain: float = 0.5
    max_iterations: int = 64

    def match(self, o3d: Any, scene: Any, model: Any, scene_features: Any, model_features: Any) -> Any:
        registration = o3d.pipelines.registration
        return registration.registration_fgr_based_on_feature_matching(
            scene,
            model,
            scene_features,
            model_features,
            registration.FastGlobalRegistrationOption(
                maximum_correspondence_distance=self.distance_gain * self.voxel, iteration_number=self.max_iterations
            ),
        )

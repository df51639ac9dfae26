"""One iteration in slow motion: five beats, from what a model point asks to the step that the cloud makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ido import Question, poses
from ido.attribution import strongest
from ido.types import BoolArray, DoubleArray, FloatArray
from ido_viz.core.inspection import Inspection
from ido_viz.core.run import MethodRun
from ido_viz.core.state import BEATS

BEAT_SECONDS = 3.5
"""Seconds that a beat takes at the normal speed."""

STEP = 0.02
"""Of a beat: as fine as it is shown."""

_HEAD, _ARC_RADIUS, _ARC_STEPS = 0.06, 0.45, 24  # of the arrow and the arc, model units and points


@dataclass(frozen=True, slots=True, eq=False)
class Inside:
    """Where the slow motion of one side's next iteration is.

    Args:
        position: beats passed, 0 to 5, with the fraction of the next.
        inspection: what that side sees and makes of it.
        point: number of the model point whose question is shown.
        question: the block that it is asked for.
        map_number: of the map that makes the update, from 1.
        T_now: the pose before the iteration, shape (4, 4).
        T_next: and after it.
    """

    position: float
    inspection: Inspection
    point: int
    question: Question
    map_number: int
    T_now: FloatArray
    T_next: FloatArray

    @property
    def beat(self) -> int:
        """Number of the beat, from 1."""
        return min(int(self.position) + 1, BEATS)

    @property
    def asks(self) -> bool:
        """Whether the scene has the colours of the point's question: in the first two beats."""
        return self.beat <= 2

    @property
    def share(self) -> float:
        """How much of the beat has passed, 0 to 1; the first two thirds of it move, then it stands to be looked at."""
        return min((self.position - (self.beat - 1)) * 1.5, 1.0)

    @property
    def bins(self) -> tuple[int, int]:
        """Numbers of the two bins of the question at the point."""
        histogram = self.inspection.side.histogram
        block, count = histogram.blocks.index(self.question), len(histogram.model.points)
        return 2 * block * count + self.point, (2 * block + 1) * count + self.point

    @property
    def counts(self) -> DoubleArray:
        """How much each scene point counts for the question, the nearest to the model point first, shape (S,)."""
        return self._answers[1][np.argsort(self._away)]

    @property
    def asked(self) -> tuple[BoolArray, DoubleArray]:
        """What the point says of every scene point, and how much each counts, as far as they have been asked: (S,)."""
        first, counts = self._answers
        share = self.share if self.beat == 1 else 1.0
        return first, np.where(np.argsort(np.argsort(self._away)) < share * len(counts), counts, 0.0)

    @property
    def _answers(self) -> tuple[BoolArray, DoubleArray]:
        """What the point says of every scene point, and how much each counts, shape (S,) each."""
        return self.question.of_point(self.inspection.side.histogram.model, self.point, self.inspection.moved)

    @property
    def _away(self) -> FloatArray:
        """How far every scene point is from the model point, shape (S,), model units."""
        return np.linalg.norm(self.inspection.moved - self.inspection.side.histogram.model.points[self.point], axis=1)

    @property
    def motion(self) -> tuple[FloatArray, FloatArray]:
        """The step as lines (n, 2, 3), model units: an arrow of the cloud's middle, an arc about its axis."""
        middle = self.inspection.moved[~self.inspection.is_outlier].mean(axis=0)
        step = self.T_next @ poses.invert(self.T_now)
        end = poses.transform(step, middle[None])[0]
        return _arrow(middle, end), _arc(middle, Rotation.from_matrix(step[:3, :3]).as_rotvec())


def inside_of(side: MethodRun, k: int, inspection: Inspection | None, position: float) -> Inside | None:
    """The slow motion of a side's iteration; None where there is none, or nothing to look into."""
    if position <= 0 or inspection is None or side.pending is not None:
        return None
    point = inspection.point if inspection.point is not None else strongest_point(inspection)
    question = inspection.question or inspection.side.histogram.questions[0]
    poses_of_both = side.T_model_scene[k], side.T_model_scene[side.clipped(k + 1)]
    return Inside(position, inspection, point, question, side.map_number(k), *poses_of_both)


def strongest_point(inspection: Inspection) -> int:
    """The model point whose bins have the largest share in the next update."""
    return int(strongest(inspection.of_points, 1)[0])


def _arrow(start: FloatArray, end: FloatArray) -> FloatArray:
    """A line with a head; without one where it is shorter than that."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length < _HEAD:
        return np.array([[start, end]])
    along = along / length
    aside = np.cross(along, [0.3, 0.5, 0.8])
    aside = _HEAD / 2 * aside / np.linalg.norm(aside)
    back = end - _HEAD * along
    return np.array([[start, end], [end, back + aside], [end, back - aside]])


def _arc(middle: FloatArray, turn: FloatArray) -> FloatArray:
    """The way of a point beside the middle that is turned about it, and the axis."""
    angle = float(np.linalg.norm(turn))
    if angle < 1e-6:
        return np.array([[middle, middle]])
    axis = turn / angle
    beside = np.cross(axis, [0.3, 0.5, 0.8])
    beside = _ARC_RADIUS * beside / np.linalg.norm(beside)
    turns = Rotation.from_rotvec(np.linspace(0.0, 1.0, _ARC_STEPS)[:, None] * turn)
    places = middle + turns.apply(beside)
    lines = np.stack([places[:-1], places[1:]], axis=1)
    spokes = np.array([[middle, places[0]], [places[-1], middle], [middle - 0.3 * axis, middle + 0.3 * axis]])
    return np.concatenate([lines, spokes])

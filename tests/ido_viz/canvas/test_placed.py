"""What is sent of nodes at a pose: what is seen, once."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
import viser
from scipy.spatial.transform import Rotation

from ido import poses
from ido_viz.canvas.placed import Echo, PlacedFrame

T = poses.exp(np.array([0.3, -0.2, 0.1, 0.5, 1.0, -2.0]))
POINTS = np.random.default_rng(0).normal(size=(20, 3)).astype(np.float32)
RED = (255, 0, 0)


class Node:
    """Stands for one of viser's: notes what is assigned."""

    def __init__(self, sent: list[tuple[str, Any]]) -> None:
        self.sent = sent

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)
        if name != "sent":
            self.sent.append((name, value))


class Scene:
    """Stands for viser's scene."""

    def __init__(self) -> None:
        self.sent: list[tuple[str, Any]] = []

    def add_frame(self, *_: object, **__: object) -> Node:
        return Node(self.sent)

    add_point_cloud = add_frame

    def names(self) -> list[str]:
        """What was sent since this was asked last."""
        names = [name for name, _ in self.sent]
        self.sent.clear()
        return names


@pytest.fixture
def scene() -> Scene:
    return Scene()


def test_a_frame_is_sent_where_it_is_and_once(scene: Scene):
    frame = PlacedFrame(cast(viser.SceneApi, scene), "/frame")
    frame.place(np.eye(4))
    assert scene.names() == []
    frame.place(T)
    sent = dict(scene.sent)
    np.testing.assert_allclose(sent["position"], T[:3, 3])
    np.testing.assert_allclose(Rotation.from_quat(sent["wxyz"], scalar_first=True).as_matrix(), T[:3, :3])
    assert scene.names() == ["wxyz", "position"]
    frame.place(T.copy())
    assert scene.names() == []
    frame.place(np.eye(4))
    assert scene.names() == ["wxyz", "position"]


def test_points_are_sent_when_they_are_seen_and_once(scene: Scene):
    echo = Echo(cast(viser.SceneApi, scene), "/echo", 0.02)
    echo.hide()
    assert "points" not in scene.names()
    echo.draw(POINTS, T, RED)
    assert dict(scene.sent)["points"] is POINTS
    assert dict(scene.sent)["visible"] is True
    assert {"points", "wxyz", "position", "visible"} <= set(scene.names())
    echo.draw(POINTS, np.eye(4), RED)
    moved = scene.names()
    assert "points" not in moved and "position" in moved
    echo.draw(POINTS[:10], np.eye(4), RED)
    assert "points" in scene.names()

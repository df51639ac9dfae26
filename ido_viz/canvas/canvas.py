"""The 3D canvas: two panes in one scene, each with the model, the moving scene and where it belongs."""

from __future__ import annotations

from functools import partial
from typing import Any, get_args

import numpy as np
import viser

from ido.types import DoubleArray, FloatArray
from ido_viz.canvas.camera import Camera
from ido_viz.canvas.pane import PANE_OFFSETS, PaneView
from ido_viz.core.actions import Actions
from ido_viz.core.frame import Frame
from ido_viz.core.geometry import point_on_ray, upright
from ido_viz.core.run import Run
from ido_viz.core.state import Pane

_CLICK_REACH = 0.08  # of a click's ray from a model point, model units: so far apart they are, or most clicks miss


class Canvas:
    """Draws both panes of one page. Moving a scene sends a pose, not points.

    Args:
        client: the page.
        actions: what clicks, the handles and the mouse do.
    """

    def __init__(self, client: viser.ClientHandle, actions: Actions) -> None:
        scene = client.scene
        self._shown, self._actions = True, actions
        scene.on_click()(self._clicked)
        scene.set_up_direction("+z")
        scene.configure_environment_map(None)  # reflections and shadows show nothing here, and halve the frames
        scene.configure_default_lights(cast_shadow=False)
        scene.add_light_ambient("/ambient", intensity=0.4)
        self._panes = [PaneView(scene, pane, partial(actions.grab, pane)) for pane in range(2)]
        self._camera = Camera(client.camera, actions.look, self._stand_beside)

    def show(self, shown: bool) -> None:
        """Show both panes, or nothing."""
        self._shown = shown
        for pane in self._panes:
            pane.show(shown)

    def _clicked(self, event: Any) -> None:
        if self._shown:  # what cannot be seen is not picked
            places = np.array([pane.place for pane in self._panes])
            self._actions.click(np.array(event.ray_origin), np.array(event.ray_direction), places)

    def _stand_beside(self, right: DoubleArray) -> None:
        """Keep the panes beside each other for who looks from elsewhere: none stands before the other."""
        for pane, offset in zip(self._panes, PANE_OFFSETS, strict=True):
            pane.stand(offset * right)

    def draw(self, frame: Frame, *, lifted: bool = False) -> None:
        """Draw both panes, lifted where something stands below them; the first time, seen from where the state says."""
        for pane in self._panes:
            pane.draw(frame)
        self._camera.lift(lifted)
        self._camera.begin(frame.state.camera)

    def look(self, camera: tuple[float, ...]) -> None:
        """Look from a place of the state."""
        self._camera.show(camera)

    def move(self, frame: Frame) -> None:
        """Move both scenes to where a frame has them, and nothing else."""
        for pane, side in zip(self._panes, frame.sides, strict=True):
            pane.move(side)


def point_at(run: Run, origin: FloatArray, direction: FloatArray, places: FloatArray) -> tuple[Pane, int] | None:
    """The pane and number of the model point that a ray in the 3D view meets; the panes stand at places (2, 3)."""
    turn = upright(run.subject.up)
    for pane, place, side in zip(get_args(Pane), places, run.sides, strict=True):
        points = turn.apply(side.histogram.model.points) + place
        found = point_on_ray(points, origin, direction, _CLICK_REACH)
        if found is not None:
            return pane, found
    return None

"""`ido_viz.show`: what it accepts, and that it says what it cannot use."""

from __future__ import annotations

import urllib.error
import urllib.request
from typing import Any

import numpy as np
import pytest

import ido_viz
from ido import Cloud, Maps
from ido_viz.core.state import State, StateError, encode
from ido_viz.serving.guests import OriginError


def state_of(page: ido_viz.EmbeddedExplorer) -> State:
    return page._app._state


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({}, {}),
        ({"rotation": 90, "seed": 7, "left": "ICP, tuned"}, {"left": "ICP, tuned"}),
        ({"shape": "urban"}, {"shape": "urban"}),
        ({"lesson": "histogram", "speed": 7}, {"speed": 7}),
        ({"code": encode(State(order="azimuth")), "hidden": ("view",)}, {"order": "azimuth", "hidden": ("view",)}),
    ],
)
def test_a_page_begins_with_what_was_asked_for(arguments: dict[str, Any], expected: dict[str, Any]):
    page = ido_viz.show(**arguments)
    try:
        state = state_of(page)
        for name, value in expected.items():
            assert getattr(state, name) == value
        for name in arguments.keys() & {"rotation", "seed"}:
            assert getattr(state.perturbation, name) == arguments[name]
        assert urllib.request.urlopen(page.url, timeout=10).status == 200
        assert page.url.startswith("http://127.0.0.1:") and f'src="{page.url}"' in page._repr_html_()
    finally:
        page.stop()
    with pytest.raises(OSError):
        urllib.request.urlopen(page.url, timeout=2)


def test_a_page_behind_a_proxy_answers_to_its_name():
    def status(origins: tuple[str, ...]) -> int:
        page = ido_viz.show(allow_origin=origins)
        try:
            request = urllib.request.Request(page.url, headers={"Host": "hub.example.org"})
            return urllib.request.urlopen(request, timeout=10).status
        except urllib.error.HTTPError as refused:
            return refused.code
        finally:
            page.stop()

    assert status(("https://hub.example.org",)) == 200
    assert status(()) == 403
    with pytest.raises(OriginError, match="looks like https"):
        ido_viz.show(allow_origin=("hub.example.org/lab",))


def test_an_own_cloud_is_registered_by_own_maps(bunny: Cloud, small_maps: Maps):
    page = ido_viz.show(cloud=bunny, maps={"A": small_maps, "B": small_maps}, rotation=20)
    try:
        state = state_of(page)
        assert (state.left, state.right, state.perturbation.rotation) == ("A", "B", 20)
    finally:
        page.stop()


class Still:
    """A method that leaves the scene where it is."""

    def __init__(self, cloud: Cloud) -> None:
        pass

    def update(self, points: np.ndarray, x: np.ndarray) -> np.ndarray:
        return np.zeros(6)


def test_an_own_method_stands_on_every_shape_and_is_shown(bunny: Cloud, small_maps: Maps):
    page = ido_viz.show(methods={"Still": Still, "Still too": Still}, cloud=bunny, maps={"A": small_maps})
    try:
        assert state_of(page).left == "Still"
        for shape in ("bunny", "urban", "own cloud"):
            assert "Still too" in page._app._library.methods(shape)
    finally:
        page.stop()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rotatoin": 90}, "unknown rotatoin; known: .*rotation"),
        ({"rotation": 900}, "rotation must lie between"),
        ({"rotation": float("nan")}, "rotation must lie between"),
        ({"points": 1.5}, "points must be a whole number"),
        ({"rotation": "90"}, "."),
        ({"left": "no such method"}, "cannot register"),
        ({"shape": "teapot"}, "there is no shape"),
        ({"speed": 900}, "speed must lie between"),
        ({"code": "ido1-damaged"}, "damaged"),
        ({"lesson": "none such"}, "unknown lesson"),
        ({"code": encode(State()), "lesson": "histogram"}, "not both"),
        ({"maps": {"A": None}}, "together"),
        ({"methods": {"DO": Still}}, "called 'DO' already"),
    ],
)
def test_what_cannot_be_used_is_said_and_nothing_is_started(arguments: dict[str, Any], message: str):
    with pytest.raises(StateError, match=message):
        ido_viz.show(**arguments)


def test_a_cloud_without_maps_is_refused(bunny: Cloud):
    with pytest.raises(StateError, match="together"):
        ido_viz.show(cloud=bunny)
    with pytest.raises(StateError, match="together"):
        ido_viz.show(cloud=bunny, maps={})

"""The explorer in a notebook cell."""

from __future__ import annotations

import html
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from ido import Cloud, Maps
from ido_viz.app import App
from ido_viz.core.library import Library, Subject, shipped_library
from ido_viz.core.plugins import OwnClass
from ido_viz.core.state import State, StateError, decode, with_values
from ido_viz.teach.lessons import lesson as lesson_of

OWN = "own cloud"
"""Name of a cloud that was given to `show`."""


class EmbeddedExplorer:
    """A running explorer that a notebook shows as a frame; `stop` ends it.

    Args:
        app: what is shown.
        height: of the frame, pixels.
    """

    def __init__(self, app: App, height: int) -> None:
        self._app = app
        self._height = height

    @property
    def url(self) -> str:
        """Where the page is, to open it in a tab of its own."""
        return self._app.url

    def stop(self) -> None:
        """Stop listening; the frame goes dead."""
        self._app.stop()

    def _repr_html_(self) -> str:
        url = html.escape(self.url)
        return (
            f'<iframe src="{url}" title="IDO Explorer" width="100%" height="{self._height}" '
            f'style="border:0" allow="clipboard-write"></iframe>'
            f'<div><a href="{url}" target="_blank">Open in a tab of its own</a></div>'
        )

    def __repr__(self) -> str:
        return f"IDO Explorer at {self.url}"


def show(
    code: str | None = None,
    *,
    lesson: str | None = None,
    cloud: Cloud | None = None,
    maps: Mapping[str, Maps] | None = None,
    methods: Mapping[str, OwnClass] | None = None,
    height: int = 760,
    port: int = 0,
    allow_origin: Collection[str] = (),
    **values: Any,
) -> EmbeddedExplorer:
    """Start an explorer and embed it in the notebook cell whose last line this is.

    It listens on 127.0.0.1, so the browser must run on the same machine, or the port be forwarded to it.

    Args:
        code: of the page to begin with, from a Share box.
        lesson: name of the lesson to begin with, instead.
        cloud: a cloud of your own to register, besides the shipped ones; needs maps.
        maps: the methods that register it, by the name that each is to have; the first two are shown.
        methods: methods and features of your own, as classes by the name that each is to have, on every shape; the
            first is shown. See `ido.extensions`.
        height: of the frame, pixels.
        port: to listen on; any free one by default.
        allow_origin: where else the page may come from, as ``("https://example.org",)`` of a proxy.
        values: of the page, as the fields of `ido_viz.core.state.State` and of `ido.Perturbation` name them:
            ``show(rotation=90, seed=7, left="ICP, tuned")``.

    Raises:
        StateError: a value, the code, the lesson or the combination of them cannot be used.
        ListenError: the port cannot be used.
        OriginError: an origin is not one.
    """
    if code is not None and lesson is not None:
        raise StateError("give a code or a lesson, not both")
    if (cloud is None) != (not maps):
        raise StateError("give cloud and maps together; ido.train makes maps of a cloud")
    state = decode(code) if code is not None else lesson_of(lesson).steps[0].state if lesson is not None else State()
    library = shipped_library()
    if cloud is not None and maps:
        own = Subject(OWN, lambda: cloud, {name: partial(_itself, its) for name, its in maps.items()})
        library = Library({**library.subjects, OWN: own})
        state = library.at_shape(state, OWN)
    if methods:
        library = library.with_methods(methods)
        state = replace(state, left=next(iter(methods)))
    if "shape" in values and values["shape"] != state.shape:
        state = library.at_shape(state, values["shape"])
    state = with_values(state, values)
    return EmbeddedExplorer(App(library.checked(state), library=library, port=port, origins=allow_origin), height)


def _itself(maps: Maps) -> Maps:
    return maps

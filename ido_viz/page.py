"""A page: builds all its parts in their places, and draws frames into them."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ido_viz.canvas.canvas import Canvas
from ido_viz.core.actions import Actions
from ido_viz.core.address import fragment_of
from ido_viz.core.basin import Basin
from ido_viz.core.comparison import Comparison
from ido_viz.core.frame import Frame
from ido_viz.core.library import Library
from ido_viz.core.state import State
from ido_viz.files.downloads import DownloadFolder
from ido_viz.own.own_cloud_tab import NAME as OWN_CLOUD
from ido_viz.own.own_cloud_tab import OwnCloudTab
from ido_viz.own.own_scan import LastScan
from ido_viz.own.preview import Preview
from ido_viz.own.workshop import Workshop
from ido_viz.panels.address_bar import AddressBar
from ido_viz.panels.basin_tab import BasinTab
from ido_viz.panels.captions import Captions
from ido_viz.panels.compare_tab import CompareTab
from ido_viz.panels.controls import Controls
from ido_viz.panels.errors_tab import ErrorsTab
from ido_viz.panels.from_browser import GESTURE, OPEN_TABS, read_gesture, unseen_field
from ido_viz.panels.help_tab import HelpTab
from ido_viz.panels.histograms_tab import HistogramsTab
from ido_viz.panels.in_browser import open_tab, tabs_before
from ido_viz.panels.inside_panel import InsidePanel
from ido_viz.panels.inspect_tab import InspectTab
from ido_viz.panels.maps_tab import MapsTab
from ido_viz.panels.markup import caption
from ido_viz.panels.picking import add_picking
from ido_viz.panels.placing import Placing
from ido_viz.panels.sweeps_tab import SweepsTab
from ido_viz.panels.training_tab import TrainingTab
from ido_viz.teach.derivations_tab import DerivationsTab
from ido_viz.teach.lesson_folder import LessonFolder
from ido_viz.teach.preset_folder import PresetFolder

_FIRST_OPEN = frozenset({"Histograms", "Maps"})
"""Tabs of charts that are open in a page that has not told yet."""

_UNTOLD = caption("The scores are hidden for this class. <i>Show all parts</i>, in the menu of commands, shows them.")

_BRAND = ((0, 114, 178), (0, 136, 208))  # of a light and of a dark page, for text on it must be readable


class Page:
    """The widgets of one browser tab.

    Args:
        client: where they are placed.
        library: shapes and methods on offer.
        state: what the page begins with.
        actions: what they do.
        step: of a lesson, that the page begins with; empty for none.
        workshop: of clouds of one's own; None for no such tab.
        last_scan: that the page has registered before it was reloaded.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        library: Library,
        state: State,
        actions: Actions,
        step: str = "",
        workshop: Workshop | None = None,
        last_scan: LastScan | None = None,
    ) -> None:
        gui = client.gui
        gui.set_panel_label("IDO Explorer")
        gui.main_panel.dock_left()
        self._gui = gui
        self._opener = gui.add_html("")
        self._opened = 0
        self._address = AddressBar(gui)  # beside all parts, for what is hidden is not there
        preview = Preview(client, self._show_panes, dark=state.dark)  # likewise: it is seen whichever tab is open
        self._captions = Captions(gui)
        self._inside = InsidePanel(gui)
        self._controls = Controls(client, library, state, actions)
        with self._controls.tabs["Learn"]:
            presets = PresetFolder(gui, actions.open_page)
        with self._controls.tabs["Share"]:
            self._downloads = DownloadFolder(client, actions.shown)
        upper = gui.add_panel(order=0)
        with upper.add_tab("Histograms"):
            self._histograms = HistogramsTab(gui, client.camera.image_height)
        with upper.add_tab("Training"):
            self._training = TrainingTab(gui)
        self._workshop, self._own = workshop, None
        if workshop is not None:
            with upper.add_tab(OWN_CLOUD):
                last_scan = last_scan or LastScan()
                self._own = OwnCloudTab(client, workshop, preview, last_scan, state, actions.show_shape)
        with upper.add_tab("Derivations"):
            self._derivations = DerivationsTab(gui)
        with upper.add_tab("Help"):
            HelpTab(gui)
        lower = gui.add_panel(order=1)
        with lower.add_tab("Maps"):
            self._maps = MapsTab(gui)
        telling: list[viser.GuiFolderHandle] = []  # what tells the scores
        self._untold: list[viser.GuiHtmlHandle] = []  # what stands there while they are hidden
        with lower.add_tab("Errors"), self._kept(telling):
            self._errors = ErrorsTab(gui)
        with lower.add_tab("Compare"), self._kept(telling):
            self._compare = CompareTab(gui, actions)
        with lower.add_tab("Basin"), self._kept(telling):
            self._basin = BasinTab(gui, actions)
        with lower.add_tab("Sweeps"), self._kept(telling):
            self._sweeps = SweepsTab(gui, actions.open_scene, actions.redraw)
        with lower.add_tab("Inspect"):
            self._inspect = InspectTab(gui, state, actions.inspect)
        with self._controls.tabs["Learn"]:
            self._lessons = LessonFolder(client, actions, self._sweeps.show_sweep, self._bring_tabs_back, state, step)
        add_picking(gui, lambda click: actions.pick(click.kind, click.pane, click.place))
        self._open = _FIRST_OPEN
        self._redraw, self._seen = actions.redraw, actions.seen
        unseen_field(gui, OPEN_TABS, self._tabs_opened)
        unseen_field(gui, GESTURE, lambda text: actions.gesture(*read_gesture(text)))
        self._placing = Placing(gui, upper, lower)
        self._parts = self._controls.parts
        self._parts |= {
            "lessons": [self._lessons.folder],
            "presets": [presets.folder],
            "download": [self._downloads.folder],
        }
        self._parts["scores"] += telling
        self._canvas = Canvas(client, actions)
        self._dark: bool | None = None
        if self._own is not None and workshop is not None:
            self._own.begin()
            workshop.watch(self._own.refresh)
            if workshop.draft is not None:
                self.open_tab(OWN_CLOUD)

    def close(self) -> None:
        """Let go of what outlives the page, and give up what is made for it."""
        self._downloads.cancel()
        if self._own is not None and self._workshop is not None:
            self._workshop.unwatch(self._own.refresh)

    def read(self, state: State) -> tuple[State, bool]:
        """The state with the widgets' newest values, and whether they all were usable as they are."""
        return self._controls.read(state)

    def show(self, state: State) -> None:
        """Write a state into the widgets, and look from its camera."""
        self._controls.show(state)
        self._canvas.look(state.camera)

    def show_iteration(self, frame: Frame) -> None:
        """Write the iteration."""
        self._controls.show_iteration(frame)
        self._lessons.follow(frame)

    def share(self, state: State) -> None:
        """Write the code of a state, and make the browser's address that of the page."""
        self._controls.show_code(state)
        self._address.show(self.fragment(state))

    def fragment(self, state: State) -> str:
        """What follows # in the address of a state."""
        return fragment_of(state, self._lessons.step)

    def copy(self, link: str) -> None:
        """Put a link into the browser's clipboard."""
        self._address.copy(link)

    def draw(self, frame: Frame, comparison: Comparison, basin: Basin, *, may_cancel: bool) -> None:
        """Draw a frame; `may_cancel` offers to cancel slow methods."""
        state = frame.state
        self._set_theme(state.dark)
        self._canvas.draw(frame, lifted=self._lessons.is_open or frame.inside is not None)
        self._placing.draw(state)
        self._hide(state)
        for name, draw in self._of_tabs(frame, comparison, basin).items():
            if name in self._open:
                draw()
        if self._own is not None:
            self._own.draw(state)
        self._controls.draw(frame, may_cancel=may_cancel)
        self._captions.draw(frame)
        self._inside.draw(frame)
        self._lessons.draw(frame)

    def _of_tabs(self, frame: Frame, comparison: Comparison, basin: Basin) -> dict[str, Callable[[], None]]:
        """How each tab of charts is drawn; those that are closed are not."""
        return {
            "Histograms": lambda: self._histograms.draw(frame),
            "Training": lambda: self._training.draw(frame),
            "Derivations": lambda: self._derivations.draw(frame.state.dark),
            "Maps": lambda: self._maps.draw(frame),
            "Errors": lambda: self._errors.draw(frame),
            "Compare": lambda: self._compare.draw(comparison, frame.state),
            "Basin": lambda: self._basin.draw(frame, basin),
            "Sweeps": lambda: self._sweeps.draw(frame.state),
            "Inspect": lambda: self._inspect.draw(frame),
        }

    def _show_panes(self, shown: bool) -> None:
        self._canvas.show(shown)

    def _tabs_opened(self, names: str) -> None:
        self._open = frozenset(names.split(","))
        self._seen()  # a page tells of its tabs once it can be seen
        self._redraw()

    def draw_inside(self, frame: Frame) -> None:
        """Draw the slow motion of an iteration, and nothing that stays the same in it."""
        self._canvas.draw(frame, lifted=self._lessons.is_open or frame.inside is not None)
        self._inside.draw(frame)
        self._controls.show_iteration(frame)

    def open_tab(self, name: str) -> None:
        """Open a tab of the charts."""
        self._opened += 1
        self._opener.content = open_tab(name, self._opened, at_end=False)

    def _bring_tabs_back(self) -> None:
        self._opened += 1
        self._opener.content = tabs_before(self._opened)

    def move(self, frame: Frame) -> None:
        """Move both scenes to where a frame has them, and nothing else."""
        self._canvas.move(frame)

    def _set_theme(self, dark: bool) -> None:
        if dark != self._dark:
            self._gui.configure_theme(
                dark_mode=dark, show_logo=False, show_share_button=False, brand_color=_BRAND[dark]
            )
            self._dark = dark

    def _hide(self, state: State) -> None:
        """Hide the parts that a lecturer has taken away, and show the others."""
        for part, handles in self._parts.items():
            for handle in handles:
                if handle.visible != (part not in state.hidden):
                    handle.visible = part not in state.hidden
        for note in self._untold:
            if note.visible != ("scores" in state.hidden):
                note.visible = "scores" in state.hidden

    def _kept(self, folders: list[viser.GuiFolderHandle]) -> viser.GuiFolderHandle:
        """A nameless folder, kept in a list, below a note that stands there while it is hidden."""
        self._untold.append(self._gui.add_html(_UNTOLD, visible=False))
        folders.append(self._gui.add_folder(None))
        return folders[-1]

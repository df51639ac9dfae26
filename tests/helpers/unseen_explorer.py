"""The explorer without a browser: what the server tells a page, and what a page would tell it."""

from __future__ import annotations

import asyncio
import threading
import time
import uuid
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

import msgspec
import numpy as np
from any_explorer import BETWEEN_CONTROLS, PATIENCE, AnyExplorer
from bs4 import BeautifulSoup, Tag
from headless import HeadlessTab, Message

from ido_viz.app import App

Value = TypeVar("Value")

_BETWEEN_MOVES = 0.02  # seconds: what is sent at once is answered in any order


class UnseenExplorer(AnyExplorer):
    """One open page that nobody sees.

    Args:
        app: whose page it is.
    """

    def __init__(self, app: App) -> None:
        self.app = app
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._tab = _WatchedTab(app.url)
        self._do(self._tab.open())
        self.wait_until("its tabs", self._tab.tabs)
        self._open = {tabs[0] for tabs in self._tab.tabs()}
        self._tell_tabs()
        self.wait_until("a run", self.readout)

    @property
    def is_open(self) -> bool:
        """Whether it has not left."""
        return not self._loop.is_closed()

    def close(self) -> None:
        """Leave, as a tab that is closed."""
        self._do(self._tab.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def pause(self, milliseconds: int = BETWEEN_CONTROLS) -> None:
        """Wait as people do between two controls."""
        time.sleep(milliseconds / 1000)

    # What can be seen

    def readout(self) -> list[list[str]]:
        """The table of numbers, row by row."""
        rows = self.elements("table.readout tr", "readout")
        return [[cell.get_text().strip() for cell in row.find_all(["td", "th"])] for row in rows]

    def verdicts(self) -> list[str]:
        """What is said of each pane over the canvas."""
        return [each.get_text("\n").strip() for each in self.elements(".verdict", "verdict")]

    def code(self) -> str:
        """What the Share box holds."""
        return self.value("State")

    def fragment(self) -> str:
        """What follows # in the browser's address."""
        (element,) = self.elements("[data-fragment]", "data-fragment")
        return str(element["data-fragment"])

    def notifications(self) -> list[str]:
        """The messages on the page that were not closed."""
        return list(self._tab.notes)

    def close_notifications(self) -> None:
        """Close all messages."""
        self._tab.notes.clear()

    def is_playing(self) -> bool:
        """Whether the play button offers to pause."""
        return bool(self._tab.seen("label", "Pause (P)"))

    def step(self) -> str | None:
        """Where the lesson is, in words; None when there is none."""
        shown = self.elements(".lesson", "lesson")
        return shown[0].get_text().strip().split(" · ")[0] if shown else None

    def slider_value(self, label: str) -> float:
        """Where a slider's thumb is."""
        return float(self.value(label))

    def options(self, label: str) -> list[str]:
        """What a menu offers."""
        return list(self._props(label)["options"])

    def value(self, label: str) -> Any:
        """What a widget holds."""
        return self._props(label)["value"]

    def says(self, text: str) -> bool:
        """Whether a text stands anywhere on the page, in a sentence or on a button."""
        buttons = (str(props.get("label")) for props in self._tab.all_seen())
        return any(text in each for each in (*self.texts(), *buttons))

    def texts(self) -> list[str]:
        """All texts of the page that are no labels of widgets."""
        return [BeautifulSoup(each, "html.parser").get_text(" ") for each in self._contents()]

    def elements(self, selector: str, within: str) -> list[Tag]:
        """What a selector finds in the HTML of the page, where a part of it stands: reading it all takes its time."""
        found = (BeautifulSoup(each, "html.parser").select(selector) for each in self._contents() if within in each)
        return [each for those in found for each in those]

    def charts(self) -> int:
        """How many charts can be seen."""
        return len(self._tab.seen("kind", "GuiUplotMessage"))

    def buttons(self) -> list[str]:
        """The labels of the buttons that can be pressed, from top to bottom."""
        shown = [props for props in self._tab.seen("kind", "GuiButtonMessage") if not props.get("disabled")]
        return [props["label"] for props in sorted(shown, key=lambda props: props["order"])]

    # What can be done

    def press(self, button: str) -> None:
        """Press a button that can be seen."""
        alone = [props for props in self._tab.seen("kind", "GuiButtonMessage") if props["label"] == button]
        assert alone or self._groups(button), f"there is no button {button}"
        props = (alone or self._groups(button))[-1]
        assert not props.get("disabled"), f"{button} cannot be pressed"
        self._tell(props, button if "options" in props else True)

    def type_key(self, key: str) -> None:
        """Press a key, with no other held."""
        (props,) = [props for props in self._tab.seen("hotkey", key.upper()) if props["modifier"] is None]
        self._do(self._tab.send(type="CommandTriggerMessage", uuid=props["uuid"]))

    def drag(self, label: str, *shares: float, steps: int = 12) -> float:
        """Drag a slider's thumb to shares of its track, one after another; where it ends."""
        props = self._props(label)
        low, high, step = props["min"], props["max"], props["step"]
        for share in shares:
            there = low + np.clip(share, 0.0, 1.0) * (high - low)
            for place in np.linspace(props["value"], there, steps + 1)[1:]:
                on_a_step = low + round((place - low) / step) * step
                self._tell(props, on_a_step if isinstance(step, int) else round(on_a_step, 9))
        return props["value"]

    def choose(self, label: str, option: str) -> None:
        """Choose from a menu."""
        assert option in self.options(label)
        self.set(label, option)

    def tick(self, label: str) -> None:
        """Tick or untick a box."""
        self.set(label, not self.value(label))

    def paste(self, code: str) -> None:
        """Paste a code into the Share box."""
        self.set("State", code)

    def set(self, label: str, value: Any) -> None:
        """Write into a widget."""
        self._tell(self._props(label), value)

    def upload(self, button: str, name: str, content: bytes) -> None:
        """Choose a file for a button that takes one."""
        self.wait_until(f"{button} to be ready", lambda: not self._tab.seen("label", button)[0].get("disabled"))
        (props,) = self._tab.seen("label", button)
        transfer = {"source_component_uuid": props["uuid"], "transfer_uuid": uuid.uuid4().hex}
        size = {"part_count": 1, "size_bytes": len(content)}
        self._do(self._tab.send(type="FileTransferStartUpload", filename=name, mime_type="", **transfer, **size))
        self._do(self._tab.send(type="FileTransferPart", part_index=0, content=content, **transfer))

    def open_tab(self, name: str) -> None:
        """Open a tab of a panel."""
        (group,) = (tabs for tabs in self._tab.tabs() if name in tabs)
        self._open = self._open - set(group) | {name}
        self._tell_tabs()

    def _tell_tabs(self) -> None:
        self.set("Open tabs", ",".join(sorted(self._open)))

    def _tell(self, props: dict[str, Any], value: Any) -> None:
        if "value" in props:
            props["value"] = value
        self._do(self._tab.send(type="GuiUpdateMessage", uuid=props["uuid"], updates={"value": value}))
        time.sleep(_BETWEEN_MOVES)

    def _props(self, label: str) -> dict[str, Any]:
        """Of the one widget with a label that has a value."""
        (props,) = [props for props in self._tab.seen("label", label) if "value" in props]
        return props

    def _groups(self, option: str) -> list[dict[str, Any]]:
        """The groups of buttons that have one of a name."""
        shown = self._tab.all_seen()
        return [props for props in shown if "Group" in props["kind"] and option in props.get("options", ())]

    def _contents(self) -> list[str]:
        """The HTML of the page, and its Markdown."""
        shown = self._tab.all_seen()
        return [text for props in shown for text in (props.get("content"), props.get("_markdown")) if text]

    def _do(self, what: Coroutine[Any, Any, Value]) -> Value:
        return asyncio.run_coroutine_threadsafe(what, self._loop).result(PATIENCE)


OpenUnseen = Callable[..., UnseenExplorer]
"""Opens a page; see `conftest.open_unseen`."""


class _WatchedTab(HeadlessTab):
    """Keeps all that the page was told of its widgets and commands."""

    def __init__(self, address: str) -> None:
        super().__init__(address)
        self._props: dict[str, dict[str, Any]] = {}

    def all_seen(self) -> list[dict[str, Any]]:
        """All widgets that are visible, as are the folders that they are in, and all commands."""
        return [props for props in list(self._props.values()) if self._is_seen(props)]

    def seen(self, key: str, value: Any) -> list[dict[str, Any]]:
        """Those of which something is said."""
        return [props for props in self.all_seen() if props.get(key) == value]

    def tabs(self) -> list[list[str]]:
        """The names of the tabs of each panel."""
        return [props["_tab_labels"] for props in self.all_seen() if props.get("_tab_labels")]

    def _is_seen(self, props: dict[str, Any]) -> bool:
        around = self._props.get(props["container"])
        return props.get("visible", True) and (around is None or self._is_seen(around))

    def _note(self, message: Message) -> None:
        super()._note(message)
        known = self._props.get(message.uuid)
        if message.type in ("GuiRemoveMessage", "RemoveCommandMessage"):
            self._props.pop(message.uuid, None)
        elif message.type in ("GuiUpdateMessage", "CommandUpdateMessage"):
            if known is not None:
                told = {key: value for key, value in message.updates.items() if key in known or key == "value"}
                known |= {key: msgspec.msgpack.decode(value) for key, value in told.items()}
        elif message.type.startswith(("Gui", "RegisterCommand")):
            chart = message.type == "GuiUplotMessage"  # whose numbers are arrays, packed in a way of their own
            told = {"visible": True} if chart else msgspec.msgpack.decode(message.props)
            if told:
                if message.value:
                    told["value"] = msgspec.msgpack.decode(message.value)
                told |= {"uuid": message.uuid, "kind": message.type, "container": message.container_uuid}
                self._props[message.uuid] = told

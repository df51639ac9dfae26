"""The command `ido-viz`."""

from __future__ import annotations

import sys
import webbrowser

import pytest

from ido_viz import command


def test_ctrl_c_while_the_browser_is_opened_ends_it_quietly(monkeypatch: pytest.MonkeyPatch):
    def interrupted(url: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(webbrowser, "open", interrupted)
    monkeypatch.setattr(command, "warm_up", lambda *_: None)
    monkeypatch.setattr(sys, "argv", ["ido-viz", "--port", "18081"])
    assert command.run() == 0

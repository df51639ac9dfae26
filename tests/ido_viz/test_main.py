"""The command `ido-viz`."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import time
import webbrowser
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from ido_viz import command
from ido_viz.__main__ import INTERRUPTED, main
from ido_viz.command import OPEN_TO_ALL, OPEN_WITH_TOKEN


@pytest.fixture
def interrupted_when_it_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C is pressed when the page is opened in a browser."""

    def interrupt(url: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(webbrowser, "open", interrupt)
    monkeypatch.setattr(command, "warm_up", lambda *_: None)


def run(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """What the command ends with; on a thread of its own, for this one may have a browser's event loop."""
    monkeypatch.setattr(sys, "argv", ["ido-viz", *arguments])
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(command.run).result()


@pytest.mark.usefixtures("interrupted_when_it_stands")
def test_ctrl_c_while_the_browser_is_opened_ends_it_quietly(monkeypatch: pytest.MonkeyPatch):
    assert run(monkeypatch, "--port", "0") == 0


def test_a_compiled_module_that_turns_ctrl_c_into_an_import_error_ends_it_as_quietly(monkeypatch: pytest.MonkeyPatch):
    def run_into(cause: BaseException) -> None:
        raise ImportError("initialization failed") from cause

    monkeypatch.setattr(command, "run", lambda: run_into(KeyboardInterrupt()))
    assert main() == INTERRUPTED
    monkeypatch.setattr(command, "run", lambda: run_into(OSError("no such library")))
    with pytest.raises(ImportError, match="initialization failed"):
        main()


@pytest.mark.parametrize("handler", [signal.default_int_handler, signal.SIG_IGN])
def test_once_its_parts_are_loaded_ctrl_c_is_what_it_was(monkeypatch: pytest.MonkeyPatch, handler: Any):
    met: list[Any] = []

    def interrupted() -> int:
        met.append(signal.getsignal(signal.SIGINT))
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "run", interrupted)
    before = signal.signal(signal.SIGINT, handler)
    try:
        assert main() == INTERRUPTED
    finally:
        signal.signal(signal.SIGINT, before)
    assert met == [handler]


@pytest.mark.usefixtures("default_interrupts")
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal")
@pytest.mark.parametrize("loading", ["ido_viz", "numba", "viser"])
def test_ctrl_c_before_the_address_is_printed_ends_it_quietly(loading: str):
    arguments = [sys.executable, "-X", "importtime", "-m", "ido_viz", "--no-open", "--port", "0"]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as explorer:
        assert explorer.stderr and explorer.stdout
        for line in explorer.stderr:  # a part that has been loaded
            if line.split("|")[-1].strip().startswith(loading):
                break
        explorer.stderr.readline()  # of the next part: before it, on a busy machine, Python has not begun the command
        time.sleep(0.05)
        explorer.send_signal(signal.SIGINT)
        said, rest = explorer.communicate(timeout=60)
    assert said == ""
    assert explorer.returncode == -signal.SIGINT, rest
    assert "Traceback" not in rest


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--port", "99999999"), "from 0 to 65535"),
        (("--host", "no-such-host.invalid"), "is not known"),
        (("--host", "198.51.100.7"), "is not an address of this machine"),
        (("--allow-origin", "example.org"), "looks like https://example.org"),
        (("--state", "ido1-damaged"), "damaged"),
        (("--sessions", "0"), "at least 1"),
        (("--servers", "0"), "at least 1"),
        (("--servers", "2", "--state", "ido1-damaged"), "damaged"),
        (("--servers", "2", "--port", "99999999"), "from 0 to 65535"),
    ],
)
def test_what_cannot_be_used_is_said_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], message: str
):
    assert run(monkeypatch, *arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert message in printed.err and printed.err.startswith("ido-viz: ")


def test_a_busy_port_that_was_asked_for_is_said(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    with socket.create_server(("127.0.0.1", 0)) as other:
        assert run(monkeypatch, "--port", str(other.getsockname()[1])) == 2
    assert "is in use" in capsys.readouterr().err


@pytest.mark.usefixtures("interrupted_when_it_stands")
@pytest.mark.parametrize(
    ("arguments", "token", "warning"),
    [
        ((), False, None),
        (("--host", "0.0.0.0"), True, OPEN_WITH_TOKEN),
        (("--host", "0.0.0.0", "--no-token"), False, OPEN_TO_ALL),
    ],
)
def test_the_printed_address_has_a_token_and_a_warning_where_others_can_connect(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: tuple[str, ...],
    token: bool,
    warning: str | None,
):
    assert run(monkeypatch, "--port", "0", *arguments) == 0
    printed = capsys.readouterr()
    assert ("/?token=" in printed.out) == token
    assert "0.0.0.0" not in printed.out
    assert printed.err.strip() == (warning or "")

"""Two servers behind nginx, as assets/docs/nginx.conf has them: a prefix, encryption, and the same server each time."""

from __future__ import annotations

import re
import shutil
import socket
import ssl
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import pytest
from browser_pages import new_page
from headless import HeadlessTab, run
from playwright.sync_api import Browser

from ido_viz.app import App
from ido_viz.core.state import State, encode

CONFIGURATION = Path(__file__).parents[2] / "assets" / "docs" / "nginx.conf"
PATIENCE = 20.0  # seconds; only a failing test waits that long
NGINX = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
pytestmark = pytest.mark.skipif(not (NGINX and shutil.which("openssl")), reason="no nginx, or no openssl")
TRUSTING = ssl._create_unverified_context()


@dataclass(frozen=True)
class Proxy:
    """Two servers, and the address that both go by."""

    address: str
    apps: tuple[App, App]

    def visitors(self) -> list[int]:
        return [app.n_sessions for app in self.apps]

    def wait_for(self, *visitors: int) -> None:
        deadline = time.monotonic() + PATIENCE
        while sorted(self.visitors()) != sorted(visitors):
            assert time.monotonic() < deadline, self.visitors()
            time.sleep(0.02)

    def new_cookie(self) -> str:
        with urllib.request.urlopen(self.address, context=TRUSTING, timeout=10) as answer:
            assert b"hashchange" in answer.read()
            return answer.headers["Set-Cookie"].split(";")[0]


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return taken.getsockname()[1]


@pytest.fixture(scope="module")
def proxy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Proxy]:
    folder, port = tmp_path_factory.mktemp("proxy"), free_port()
    origin = f"https://localhost:{port}"
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    making = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj", "/CN=localhost"]
    subprocess.run([*making, "-keyout", str(key), "-out", str(certificate)], check=True, capture_output=True)
    apps = (App(State(playing=False), port=0, origins=(origin,)), App(State(playing=False), port=0, origins=(origin,)))
    ours = CONFIGURATION.read_text(encoding="utf-8")
    for its, here in (
        ("listen 443 ssl", f"listen 127.0.0.1:{port} ssl"),
        ("127.0.0.1:8081", f"127.0.0.1:{apps[0].server.get_port()}"),
        ("127.0.0.1:8082", f"127.0.0.1:{apps[1].server.get_port()}"),
        ("/etc/ssl/certs/class.example.org.pem", str(certificate)),
        ("/etc/ssl/private/class.example.org.key", str(key)),
        ("server_name class.example.org", "server_name localhost"),
    ):
        assert its in ours
        ours = re.sub(rf"^([^#\n]*){re.escape(its)}", rf"\g<1>{here}", ours, flags=re.MULTILINE)
    kept = " ".join(f"{name}_temp_path {folder};" for name in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
    whole = folder / "nginx.conf"
    whole.write_text(
        f"daemon off; pid {folder}/pid; error_log {folder}/errors; events {{}}\n"
        f"http {{ access_log off; {kept}\n{ours}}}\n",
        encoding="utf-8",
    )
    with subprocess.Popen([str(NGINX), "-c", str(whole), "-e", str(folder / "errors")]) as nginx:
        try:
            deadline = time.monotonic() + PATIENCE
            while True:
                try:
                    socket.create_connection(("127.0.0.1", port), timeout=1).close()
                    break
                except OSError:
                    assert nginx.poll() is None and time.monotonic() < deadline, (folder / "errors").read_text()
                    time.sleep(0.05)
            yield Proxy(f"{origin}/explorer/", apps)
        finally:
            nginx.terminate()
            for app in apps:
                app.stop()


def test_a_visitor_has_a_server_of_their_own_and_all_of_them_both(proxy: Proxy):
    async def visit(cookie: str, times: int) -> list[list[int]]:
        found = []
        for _ in range(times):
            tab = HeadlessTab(proxy.address)
            await tab.open(ssl=TRUSTING, additional_headers={"Cookie": cookie})
            found.append(proxy.visitors())
            await tab.close()
            await tab.until("the end of the visit", lambda: sum(proxy.visitors()) == 0)
        return found

    first = run(visit(proxy.new_cookie(), 3))
    assert first.count(first[0]) == 3
    others = {tuple(run(visit(proxy.new_cookie(), 1))[0]) for _ in range(16)}
    assert others == {(0, 1), (1, 0)}


def test_a_file_comes_through(proxy: Proxy):
    async def take_along() -> list[str]:
        tab = HeadlessTab(proxy.address)
        await tab.open(ssl=TRUSTING, additional_headers={"Cookie": proxy.new_cookie()})
        await tab.press("Curves (.csv)")
        await tab.until("the file", lambda: tab.files)
        await tab.close()
        return tab.files

    assert run(take_along()) == ["ido-bunny-0.csv"]


def test_a_browser_finds_its_page_by_the_prefix_and_again_after_a_reload(proxy: Proxy, browser: Browser):
    proxy.wait_for(0, 0)
    state = State(left="ICP, tuned", iteration=3, playing=False)
    page = new_page(browser, ignore_https_errors=True)
    try:
        page.goto(f"{proxy.address}#state={quote(encode(state))}")
        page.get_by_role("row", name="PointRMSE").wait_for()
        proxy.wait_for(0, 1)
        (session,) = (session for app in proxy.apps for session in app._sessions.values())
        assert (session._state.left, session._state.iteration) == ("ICP, tuned", 3)
        assert session._link().startswith(f"{proxy.address}#state=")
        page.reload()
        page.get_by_role("row", name="PointRMSE").wait_for()
        assert page.url.startswith(f"{proxy.address}#state=")
    finally:
        page.close()

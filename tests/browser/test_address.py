"""The address is the page: opened, loaded again, pasted, copied, and found by a server that was started anew."""

from __future__ import annotations

import io
from dataclasses import replace
from urllib.parse import quote

import zxingcpp
from any_explorer import AT_THE_END
from explorer import Explorer, OpenExplorer, box_of
from PIL import Image

from ido import Perturbation
from ido_viz.app import App
from ido_viz.core.address import read_fragment
from ido_viz.core.state import State, StateError, decode, encode
from ido_viz.teach.lessons import lesson

ELSEWHERE = State(
    perturbation=Perturbation(rotation=75.0, seed=8),
    left="Improved DO",
    right="DO",
    iteration=6,
    playing=False,
    replay=False,
)
AWAY = "The explorer is not running"


def state_of(explorer: Explorer) -> State | None:
    """The state that the browser's address has, if it has one: one that was refused is there until it is put right."""
    try:
        code = read_fragment(explorer.page.url.partition("#")[2]).code
        return decode(code) if code else None
    except StateError:
        return None


def expect_address(explorer: Explorer, state: State) -> None:
    explorer.wait_until("the address", lambda: state_of(explorer) == state)


def open_at(explorer: Explorer, fragment: str, query: str = "") -> None:
    explorer.page.goto(f"{explorer.app.url}/{query}#{fragment}")
    explorer.wait_ready()


def test_an_address_opens_exactly_its_page_which_a_reload_keeps_while_it_frees_the_session_before(
    open_explorer: OpenExplorer,
):
    explorer = open_explorer(wait=False)
    explorer.app = app = App(AT_THE_END, port=0)
    try:
        open_at(explorer, f"state={encode(ELSEWHERE)}")
        explorer.expect_numbers(ELSEWHERE)
        value = explorer.drag("Noise", 0.7)
        expected = replace(ELSEWHERE, perturbation=replace(ELSEWHERE.perturbation, noise=value))
        expect_address(explorer, expected)
        explorer.page.reload()
        explorer.wait_ready()
        explorer.expect_numbers(expected)
        assert explorer.expect_to_agree() == expected == state_of(explorer) == decode(explorer.code())
        explorer.wait_until("the session before to be freed", lambda: app.n_sessions == 1)
    finally:
        app.stop()


def test_the_address_follows_in_few_steps(explorer: Explorer):
    expect_address(explorer, AT_THE_END)
    explorer.page.evaluate(
        "() => { window.replaced = 0; history.replaceState = (...given) => {"
        " window.replaced += 1; History.prototype.replaceState.apply(history, given); }; }"
    )
    for _ in range(3):
        explorer.drag("Rotation", 0.2, 0.6, steps=40)
    explorer.wait_until("the last place", lambda: explorer.state() == state_of(explorer) != AT_THE_END)
    assert 0 < explorer.page.evaluate("replaced") < 30
    explorer.page.evaluate("() => delete history.replaceState")


def test_another_fragment_in_an_open_page_leads_to_its_page_and_back_to_the_one_before(explorer: Explorer):
    expect_address(explorer, AT_THE_END)
    explorer.page.evaluate("hash => location.hash = hash", f"state={encode(ELSEWHERE)}")
    explorer.expect_numbers(ELSEWHERE)
    assert explorer.expect_to_agree() == ELSEWHERE
    explorer.page.go_back()
    explorer.expect_numbers(AT_THE_END)
    expect_address(explorer, AT_THE_END)


def test_a_lesson_s_step_is_opened_by_its_name_and_is_there_after_a_reload(open_explorer: OpenExplorer):
    explorer = open_explorer(wait=False)
    explorer.page.goto(f"{explorer.app.url}/?lesson=histogram/2")
    count = explorer.page.get_by_text(f"Step 2 of {len(lesson('histogram').steps)}")
    count.wait_for()
    explorer.press("New seed")
    explorer.wait_until("its address", lambda: "lesson=histogram/2&state=" in explorer.page.url)
    explorer.wait_until("the new seed", lambda: state_of(explorer) != lesson("histogram").steps[1].state)
    expected = state_of(explorer)
    explorer.page.reload()
    count.wait_for()
    assert expected is not None
    expect_address(explorer, expected)
    explorer.choose("Lesson", "Choose a lesson")
    explorer.wait_until("an address without the lesson", lambda: "lesson=" not in explorer.page.url)
    explorer.wait_until("the page's own state", lambda: state_of(explorer) == explorer.state() != expected)


def test_a_bad_address_opens_the_page_of_its_own_server_with_its_defaults_and_says_what_is_wrong(
    open_explorer: OpenExplorer,
):
    explorer = open_explorer(wait=False)
    sockets: list[str] = []
    explorer.page.on("websocket", lambda socket: sockets.append(socket.url))
    elsewhere = "?websocket=ws://127.0.0.1:9/&playbackPath=http://127.0.0.1:9/evil.viser"
    for query, fragment, message in (
        (elsewhere, "state=" + quote("<img src=x onerror=alert(1)>"), "a code starts with"),
        ("", "lesson=" + quote("<b>none"), "unknown lesson '<b>none'"),
    ):
        explorer.page.goto("about:blank")
        open_at(explorer, fragment, query)
        expect_refusal(explorer, message)
        assert "evil" not in explorer.page.url and ":9/" not in explorer.page.url
    assert sockets and all(f":{explorer.app.server.get_port()}/" in url for url in sockets)
    for fragment, message in (
        ("state=ido1-damaged", "damaged"),
        ("state=" + "a" * 50_000, "more than 2000 characters"),
    ):
        explorer.close_notifications()
        explorer.page.evaluate("hash => location.hash = hash", fragment)  # as pasted into the open page's address
        expect_refusal(explorer, message)


def expect_refusal(explorer: Explorer, message: str) -> None:
    """See that the page says why an address cannot be used, and has its defaults."""
    explorer.wait_until("a message", explorer.notifications)
    assert "This address cannot be used" in explorer.notifications()[0] and message in explorer.notifications()[0]
    explorer.expect_numbers(AT_THE_END)
    expect_address(explorer, AT_THE_END)


def test_a_server_that_is_started_anew_finds_the_page_as_it_was(open_explorer: OpenExplorer):
    explorer = open_explorer(wait=False)
    explorer.app = app = App(AT_THE_END, port=0)
    port = app.server.get_port()
    banner = explorer.page.get_by_role("status").filter(has_text=AWAY)
    try:
        explorer.open()
        explorer.press("Back (B)")
        value = explorer.drag("Rotation", 0.3)
        explorer.wait_until("its address", lambda: explorer.state() == state_of(explorer))
        before = explorer.expect_to_agree()
        assert before.perturbation.rotation == value
        place = box_of(explorer.canvas())
        app.stop()
        banner.wait_for()
        app = App(port=port)
        banner.wait_for(state="detached")
        explorer.wait_ready()
        explorer.expect_numbers(before)
        assert explorer.expect_to_agree() == before == state_of(explorer)
        assert box_of(explorer.canvas()) == place
        explorer.expect_alive()
    finally:
        app.stop()


# What is copied


def copied(explorer: Explorer) -> str:
    """The link that the button copies."""
    explorer.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    explorer.page.evaluate("navigator.clipboard.writeText('')")
    explorer.press("Copy link")
    explorer.wait_until("a copy", lambda: explorer.page.evaluate("navigator.clipboard.readText()"))
    return explorer.page.evaluate("navigator.clipboard.readText()")


def test_the_copied_link_is_that_of_the_address(explorer: Explorer):
    explorer.press("Back (B)")
    explorer.wait_until("its address", lambda: state_of(explorer) not in (None, AT_THE_END))
    assert copied(explorer) == explorer.page.url


def test_a_tick_just_made_is_in_the_link_that_is_copied(explorer: Explorer):
    explorer.row("Hide scene").get_by_role("checkbox").click()
    link = copied(explorer)
    assert decode(read_fragment(link.partition("#")[2]).code).hidden == ("scene",)


def test_code_and_link_of_a_playing_page_are_those_of_what_is_shown(open_explorer: OpenExplorer):
    playing = State(speed=1)
    explorer = open_explorer(playing)
    expect_address(explorer, playing)
    assert explorer.state() == playing
    value = explorer.drag("Noise", 0.7)
    expected = replace(playing, perturbation=replace(playing.perturbation, noise=value))
    explorer.wait_until("the code", lambda: explorer.state() == expected)
    assert explorer.is_playing()
    assert decode(read_fragment(copied(explorer).partition("#")[2]).code) == expected
    expect_address(explorer, expected)


def test_a_class_scans_the_address_that_others_can_open(explorer: Explorer, open_explorer: OpenExplorer):
    only_here, lecturer = explorer, open_explorer(wait=False)
    only_here.press("QR code")
    reason = only_here.page.get_by_text("Only this machine can open this page")
    reason.wait_for()
    only_here.press("Close")
    reason.wait_for(state="detached")
    lecturer.app = app = App(AT_THE_END, host="0.0.0.0", port=0)
    try:
        lecturer.page.goto(f"http://127.0.0.1:{app.server.get_port()}/?{app.url.partition('?')[2]}")
        lecturer.wait_ready()
        lecturer.close_notifications()  # of the browser, over the place of the window
        lecturer.press("QR code")
        window = lecturer.page.get_by_role("dialog")
        link = f"{app.url}#state={encode(AT_THE_END)}"
        window.get_by_text(link, exact=True).wait_for()

        def scanned() -> list[str]:
            picture = Image.open(io.BytesIO(lecturer.page.screenshot()))
            return [each.text for each in zxingcpp.read_barcodes(picture)]

        lecturer.wait_until("the code to be there", scanned)
        assert scanned() == [link]
        lecturer.page.keyboard.press("Escape")
        window.wait_for(state="detached")
    finally:
        app.stop()


def test_the_link_is_copied_where_the_browser_has_no_clipboard_for_pages(explorer: Explorer):
    """As on an address without encryption that is not the machine's own."""
    explorer.page.evaluate("Object.defineProperty(navigator, 'clipboard', {value: undefined, configurable: true})")
    explorer.press("Back (B)")
    explorer.wait_until("its address", lambda: state_of(explorer) not in (None, AT_THE_END))
    explorer.press("Copy link")
    explorer.wait_until("the message", explorer.notifications)
    explorer.page.evaluate("document.body.prepend(document.createElement('textarea'))")
    field = explorer.page.locator("textarea").first
    field.focus()
    explorer.page.keyboard.press("Control+V")
    assert field.input_value() == explorer.page.url
    field.evaluate("field => { field.remove(); delete navigator.clipboard; }")

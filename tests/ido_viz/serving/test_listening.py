"""Where a page listens: what cannot be used is said at once, and the printed address is one that can be opened."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from ipaddress import ip_address
from urllib.parse import urlsplit

import pytest

from ido_viz.serving.listening import USUAL_PORT, ListenError, authority, is_open, listen

ELSEWHERE = "198.51.100.7"  # an address for documents, nobody's


@pytest.fixture
def busy() -> Iterator[int]:
    """A port of this machine that is in use."""
    with socket.create_server(("127.0.0.1", 0)) as other:
        yield other.getsockname()[1]


@pytest.mark.parametrize(
    ("host", "port", "message"),
    [
        ("127.0.0.1", 99_999_999, "from 0 to 65535, not 99999999"),
        ("127.0.0.1", -1, "from 0 to 65535"),
        ("no-such-host.invalid", 0, "'no-such-host.invalid' is not known"),
        ("a" * 70, 0, "is not known"),
        (ELSEWHERE, 0, f"{ELSEWHERE} is not an address of this machine"),
    ],
)
def test_a_place_that_cannot_be_had_is_said(host: str, port: int, message: str):
    with pytest.raises(ListenError, match=message):
        listen(host, port)


def test_a_busy_port_that_was_asked_for_is_said(busy: int):
    with pytest.raises(ListenError, match=f"port {busy} is in use"):
        listen("127.0.0.1", busy)


def test_without_a_port_the_next_free_one_is_taken():
    with listen("127.0.0.1", None) as first, listen("127.0.0.1", None) as second:
        assert USUAL_PORT <= first.getsockname()[1] < second.getsockname()[1]


def test_a_page_for_all_is_printed_with_an_address_that_leads_to_it():
    with listen("0.0.0.0", 0) as listener:
        assert is_open(listener)
        parts = urlsplit(f"//{authority(listener, '0.0.0.0')}")
        assert parts.hostname and parts.hostname != "0.0.0.0"
        socket.create_connection((parts.hostname, parts.port), timeout=5).close()
        if _has_network():
            assert not ip_address(parts.hostname).is_loopback


def _has_network() -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        return probe.connect_ex((ELSEWHERE, 9)) == 0


def test_only_this_machine_reaches_what_listens_on_its_own_address():
    with listen("127.0.0.1", 0) as listener:
        assert not is_open(listener)
        assert authority(listener, "127.0.0.1") == f"127.0.0.1:{listener.getsockname()[1]}"


@pytest.mark.skipif(not socket.has_ipv6, reason="this Python has no IPv6")
def test_an_address_of_ipv6_stands_in_brackets():
    try:
        listener = listen("::1", 0)
    except ListenError:
        pytest.skip("this machine has no IPv6")
    with listener:
        assert authority(listener, "::1") == f"[::1]:{listener.getsockname()[1]}"
        assert not is_open(listener)

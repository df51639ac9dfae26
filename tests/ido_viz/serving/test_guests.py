"""Who is answered: our own pages, by whatever way they come, and nobody else's."""

from __future__ import annotations

import pytest
from websockets.datastructures import Headers
from websockets.http11 import Request

from ido_viz.serving.guests import Guests, OriginError, read_origins

PROXY = "https://Class.example.org"
GUESTS = Guests(frozenset({"lectern"}), read_origins([PROXY]))


def refused(guests: Guests, host: str, origin: str | None = None, path: str = "/") -> bool:
    headers = Headers([("Host", host)] + ([("Origin", origin)] if origin is not None else []))
    return guests.refusal(Request(path, headers)) is not None


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("127.0.0.1:8080", "http://127.0.0.1:8080"),
        ("localhost:9000", "http://localhost:9000"),  # forwarded to another port
        ("[::1]:8080", "http://[::1]:8080"),
        ("192.168.1.5:8080", "http://192.168.1.5:8080"),
        ("lectern:8080", "http://LECTERN:8080"),
        ("class.example.org", "https://class.example.org"),
        ("127.0.0.1:8080", "https://class.example.org"),  # a proxy that tells its own name, or not
        ("127.0.0.1:8080", None),  # no browser
    ],
)
def test_our_own_pages_are_answered(host: str, origin: str | None):
    assert not refused(GUESTS, host, origin)


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("127.0.0.1:8080", "http://evil.example"),
        ("127.0.0.1:8080", "http://127.0.0.1:3000"),
        ("127.0.0.1:8080", "http://localhost:8080"),
        ("127.0.0.1:8080", "null"),
        ("127.0.0.1:8080", ""),
        ("127.0.0.1:8080", "http://class.example.org"),
        ("evil.example:8080", "http://evil.example:8080"),  # a name that was given our address
        ("evil.example:8080", None),
        ("127.0.0.1.evil.example", None),
        ("[::1", None),
        ("", None),
    ],
)
def test_other_pages_are_refused(host: str, origin: str | None):
    assert refused(GUESTS, host, origin)


def test_a_request_with_two_hosts_is_refused():
    twice = Headers([("Host", "127.0.0.1:8080"), ("Host", "evil.example")])
    assert GUESTS.refusal(Request("/", twice)) is not None
    assert GUESTS.refusal(Request("/", Headers())) is not None


@pytest.mark.parametrize("path", ["/", "/?token=", "/?token=secre", "/?token=secret1", "/?Token=secret", "/secret"])
def test_where_there_is_a_token_none_but_it_opens(path: str):
    guests = Guests(token="secret")
    assert refused(guests, "127.0.0.1:8080", path=path)
    assert not refused(guests, "127.0.0.1:8080", path="/?fragment=state&token=secret")


@pytest.mark.parametrize(
    "text",
    ["example.org", "https://", "ftp://example.org", "https://example.org/", "https://a@b.org", "https://[::1", "*"],
)
def test_what_is_no_origin_is_said(text: str):
    with pytest.raises(OriginError, match="an origin looks like"):
        read_origins([text])

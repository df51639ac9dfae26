"""Who may connect.

A browser lets any web page connect to any port of the machine that it runs on, and says in `Origin` which page asks. A
page of ours comes from where it connects to, so the two must agree. `Host` says by which name we were found: a stranger
can give a name of his own our address, so that his pages seem to be ours, but no IP address.
"""

from __future__ import annotations

import secrets
from collections.abc import Collection
from dataclasses import dataclass
from ipaddress import ip_address
from urllib.parse import parse_qs, urlsplit

from websockets.http11 import Request


class OriginError(ValueError):
    """An origin cannot be used; the message says what one looks like."""


@dataclass(frozen=True, slots=True)
class Guests:
    """Whom we answer.

    Args:
        names: by which this machine may be called, besides ``localhost`` and IP addresses; small letters.
        origins: where else our page may come from, as `read_origins` gives them.
        token: what the page's address must bring along; None if it need not.
    """

    names: frozenset[str] = frozenset()
    origins: frozenset[str] = frozenset()
    token: str | None = None

    def refusal(self, request: Request) -> str | None:
        """Why a request is not answered, in a sentence for a person; None if it is."""
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(hosts) != 1 or len(origins) > 1:
            return "The request must name one host, and one origin at most."
        name = _name(hosts[0])
        names = {"localhost"} | self.names | {_name(_authority(origin)) for origin in self.origins}
        if name not in names and not _is_address(name):
            return "This explorer does not go by that name. Behind a proxy, start it with --allow-origin."
        for origin in origins:
            if origin.lower() not in self.origins and _authority(origin) != hosts[0].lower():
                return "Pages from elsewhere may not connect. Behind a proxy, start the explorer with --allow-origin."
        if self.token is not None:
            given = parse_qs(urlsplit(request.path).query).get("token", [""])[0]
            if not secrets.compare_digest(given.encode(), self.token.encode()):
                return "The token is missing or wrong. Open the whole address that ido-viz printed."
        return None


def read_origins(texts: Collection[str]) -> frozenset[str]:
    """Origins as browsers write them.

    Raises:
        OriginError: one is not an origin.
    """
    return frozenset(map(_read_origin, texts))


def _read_origin(text: str) -> str:
    scheme, _, authority = text.lower().partition("://")
    if scheme not in ("http", "https") or not _name(authority) or set(authority) & set("/?#@"):
        raise OriginError(f"an origin looks like https://example.org, with no path, not {text!r}")
    return text.lower()


def _authority(origin: str) -> str:
    """Host and port of an origin; nothing if it has none, as the origin ``null``."""
    return origin.lower().partition("://")[2]


def _name(authority: str) -> str:
    """The host of ``host:port``; nothing if it cannot be read."""
    try:
        return urlsplit(f"//{authority}").hostname or ""
    except ValueError:
        return ""


def _is_address(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True

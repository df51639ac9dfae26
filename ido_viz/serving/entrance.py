"""The address that browsers open, and who may open it."""

from __future__ import annotations

import secrets
import socket
from dataclasses import dataclass

from ido_viz.serving.guests import Guests
from ido_viz.serving.listening import authority, is_open

_TOKEN_BYTES = 12


@dataclass(frozen=True, slots=True)
class Entrance:
    """Where pages come in.

    Args:
        address: as ``http://host:port``.
        is_open: whether other machines can connect.
        guests: who is answered.
    """

    address: str
    is_open: bool
    guests: Guests

    @classmethod
    def of(cls, listener: socket.socket, host: str, *, token: bool, origins: frozenset[str]) -> Entrance:
        """That of a socket which listens.

        Args:
            listener: the socket.
            host: as it was asked for.
            token: whether an address that other machines can open has a token, without which nobody is answered.
            origins: from where else a page of ours may come, as `guests.read_origins` gives them.
        """
        open_to_others = is_open(listener)
        machine = socket.gethostname().lower()
        names = {machine, f"{machine}.local"} if open_to_others else set[str]()
        its_token = secrets.token_urlsafe(_TOKEN_BYTES) if open_to_others and token else None
        guests = Guests(frozenset({host.lower()} | names), origins, its_token)
        return cls(f"http://{authority(listener, host)}", open_to_others, guests)

    @property
    def query(self) -> str:
        """What follows the host in the address of the page."""
        return f"/?token={self.guests.token}" if self.guests.token else ""

    @property
    def url(self) -> str:
        """Where the page is, for those who may open it."""
        return self.address + self.query

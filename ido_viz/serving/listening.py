"""The socket that the page is served from, and the name by which browsers find it."""

from __future__ import annotations

import errno
import socket
from ipaddress import ip_address

USUAL_PORT = 8080
_TRIED = 1000

_PLACES_ELSEWHERE = ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1"))
"""Addresses that are kept for documents (RFC 5737, RFC 3849): nobody has them, and nothing is sent to them."""


class ListenError(ValueError):
    """The host or the port cannot be used; the message says what to do."""


def listen(host: str, port: int | None) -> socket.socket:
    """A socket that listens.

    Args:
        host: a name or an address of this machine.
        port: 0 for any free one; None for the first free one from `USUAL_PORT` on.

    Raises:
        ListenError: the host is unknown or another machine's, or the port cannot be had.
    """
    if port is not None and not 0 <= port <= 65535:
        raise ListenError(f"a port is a number from 0 to 65535, not {port}")
    family, (address, *scope) = _found(host)
    for candidate in range(USUAL_PORT, USUAL_PORT + _TRIED) if port is None else (port,):
        try:
            return socket.create_server(
                (address, candidate, *scope),  # type: ignore[arg-type]
                family=family,
                dualstack_ipv6=address == "::" and socket.has_dualstack_ipv6(),
            )
        except OSError as error:
            if error.errno == errno.EADDRINUSE and port is None:
                continue
            raise ListenError(_why(error, host, candidate)) from error
    raise ListenError(f"no port from {USUAL_PORT} on is free; give one with --port, or 0 for any")


def _found(host: str) -> tuple[socket.AddressFamily, tuple[str, *tuple[int, ...]]]:
    """The first address of a host, and what else names the place; without a port."""
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError) as error:
        raise ListenError(f"the host {host!r} is not known; give an address of this machine, as 127.0.0.1") from error
    family, _, _, _, (address, _, *scope) = found[0]
    return family, (str(address), *map(int, scope))


def _is_open(address: str) -> bool:
    return not ip_address(_plain(address)).is_loopback


def _why(error: OSError, host: str, port: int) -> str:
    """What is wrong with a host and a port, and what to do."""
    if error.errno == errno.EADDRINUSE:
        return f"port {port} is in use; give another one, or no --port to take the next free one"
    if error.errno == errno.EADDRNOTAVAIL:
        return f"{host} is not an address of this machine; give 127.0.0.1, or 0.0.0.0 for all addresses it has"
    if error.errno == errno.EACCES:
        return f"port {port} may not be used by you; give one above 1023"
    return f"cannot listen on {host}, port {port}: {error.strerror or error}"


def opens_to_others(host: str) -> bool:
    """Whether other machines could connect to a host, as it is asked for.

    Raises:
        ListenError: the host is unknown.
    """
    _, (address, *_) = _found(host)
    return _is_open(address)


def is_open(listener: socket.socket) -> bool:
    """Whether other machines can connect."""
    return _is_open(_bound(listener))


def authority(listener: socket.socket, host: str) -> str:
    """Host and port as they stand in an address that others can open; `host` is what was asked for."""
    if ip_address(_bound(listener)).is_unspecified:
        host = _reachable()
    return f"{f'[{host}]' if ':' in host else host}:{listener.getsockname()[1]}"


def _bound(listener: socket.socket) -> str:
    return _plain(listener.getsockname()[0])


def _plain(address: str) -> str:
    return address.partition("%")[0]  # what follows names a network card


def _reachable() -> str:
    """The address from which this machine would reach others, so that they reach it there."""
    for family, elsewhere in _PLACES_ELSEWHERE:
        try:
            with socket.socket(family, socket.SOCK_DGRAM) as probe:
                probe.connect((elsewhere, 9))
                return probe.getsockname()[0]
        except OSError:  # no such network
            continue
    return socket.gethostname()

"""Why a router does not let a module in: Zenoh itself closes the door without a word."""

from __future__ import annotations

import asyncio
import re
import socket
import ssl
import time
from collections.abc import Callable
from dataclasses import dataclass

from tca_bus._credentials import ENCRYPTED, Credentials

PROBE_SECONDS = 1.0
"""Wall seconds that a router may take to accept a connection, or to turn it away."""

QUICK_SECONDS = 0.4
"""A router that turns a session away does so at once; one that is busy or stuck does not."""

TRIES = 3
"""So many times in a row a router must turn a session away: it may just be starting or ending."""

TRY_PAUSE = 0.05

_ADDRESS = re.compile(r"^\w+/(?P<host>.+):(?P<port>\d+)$")

TryToOpen = Callable[[], None]
"""Opens a Zenoh session and closes it again; raises when that does not work."""


@dataclass(frozen=True, slots=True)
class Door:
    """Where a session wants in, and with what."""

    endpoint: str
    credentials: Credentials


def why_shut_out(door: Door, try_to_open: TryToOpen) -> str | None:
    """Say why somebody who listens at an endpoint lets no session in.

    Takes a few seconds at the most, on a thread. None when nobody listens, when it works after
    all, or when it cannot be told.
    """
    address = _ADDRESS.fullmatch(door.endpoint)
    if address is None:
        return None
    place = (address["host"].strip("[]"), int(address["port"]))
    if door.endpoint.startswith("tls/"):
        return _why_no_tls(place, door.credentials) or _why_turned_away(place, door, try_to_open)
    if door.endpoint.startswith("tcp/"):
        return _why_turned_away(place, door, try_to_open)
    return None


def _why_no_tls(place: tuple[str, int], credentials: Credentials) -> str | None:
    """Shake hands as Zenoh would; what is wrong with a certificate shows there."""
    context = ssl.create_default_context(cafile=str(credentials.authority))
    try:
        if credentials.pair is not None:
            pair = credentials.pair
            context.load_cert_chain(pair.certificate, pair.private_key)
        with socket.create_connection(place, PROBE_SECONDS) as connection:
            _shake_hands(context, connection, place[0])
    except ssl.SSLCertVerificationError as error:
        return _about_the_router(error.verify_message, credentials)
    except ssl.SSLError as error:
        return _about_us(error.reason or str(error), credentials)
    except OSError:
        return None
    return None


def _shake_hands(context: ssl.SSLContext, connection: socket.socket, host: str) -> None:
    with context.wrap_socket(connection, server_hostname=host) as secured:
        # In TLS 1.3 the other side says only after the handshake what it thinks of us.
        secured.settimeout(PROBE_SECONDS / 2)
        secured.recv(1)


def _about_the_router(what: str, credentials: Credentials) -> str:
    advice = (
        f"it must be signed by {credentials.authority}, name the host that is connected to "
        "('tca keys make --host', 'tca keys list') and be in date ('tca keys renew')"
    )
    return f"the router's certificate is not accepted: {what}; {advice}"


def _about_us(reason: str, credentials: Credentials) -> str:
    said = reason.lower().replace("_", " ")
    if credentials.pair is None:
        return f"the router wants a certificate ({said}); name a folder of keys with --keys"
    advice = (
        "it must be in date ('tca keys renew') and signed by the router's own authority: both "
        "need keys of one 'tca keys make'"
    )
    return f"the router does not accept {credentials} ({said}); {advice}"


def _why_turned_away(place: tuple[str, int], door: Door, try_to_open: TryToOpen) -> str | None:
    for _ in range(TRIES):
        if not (_accepts(place) and _is_turned_away(try_to_open)):
            return None
        time.sleep(TRY_PAUSE)
    return _likely_cause(door)


def _accepts(place: tuple[str, int]) -> bool:
    try:
        socket.create_connection(place, PROBE_SECONDS).close()
    except OSError:
        return False
    return True


def _is_turned_away(try_to_open: TryToOpen) -> bool:
    began = time.monotonic()
    try:
        try_to_open()
    except Exception:
        return time.monotonic() - began < QUICK_SECONDS
    return False


def _likely_cause(door: Door) -> str:
    if door.credentials.user is not None:
        return (
            f"whoever listens there closes the door on user {door.credentials.user!r}: the router "
            "does not know it, has another password for it, or asks for none; 'tca keys "
            "password' makes one"
        )
    if door.endpoint.startswith(ENCRYPTED):
        return "whoever listens there is no router, or one that wants user and password"
    return (
        "whoever listens there closes the door: the router wants user and password or a "
        "certificate (--keys, and an endpoint tls/HOST:PORT), or it is no router at all"
    )


async def explain(door: Door, try_to_open: TryToOpen) -> str | None:
    """`why_shut_out` on a thread."""
    return await asyncio.to_thread(why_shut_out, door, try_to_open)

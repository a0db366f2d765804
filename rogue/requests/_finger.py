"""Asking a finger server who somebody is (RFC 1288)."""

from __future__ import annotations

import asyncio
import contextlib
import re
from dataclasses import dataclass

from rogue.errors import FingerError
from tca_bus import ConfigError

PORT = 79
"""Finger's own port."""

PATIENCE = 3.0
"""Wall seconds for a whole look-up."""

MOST_BYTES = 65_536
"""A longer reply is not read."""

_ADDRESS = re.compile(r"(?P<host>\[[0-9A-Fa-f:.%]+\]|[A-Za-z0-9._-]+)(?::(?P<port>\d{1,5}))?")
_USER = re.compile(r"[a-z0-9][a-z0-9._-]{0,63}")


@dataclass(frozen=True, slots=True)
class FingerServer:
    """Where to ask."""

    host: str
    port: int = PORT

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return host if self.port == PORT else f"{host}:{self.port}"


def finger_server(text: str, *, setting: str = "--finger") -> FingerServer:
    """Read ``HOST`` or ``HOST:PORT``; an IPv6 address stands in brackets.

    Raises:
        ConfigError: it is neither.
    """
    found = _ADDRESS.fullmatch(text.strip())
    port = int(found["port"] or PORT) if found else 0
    if found is None or not 0 < port < 65_536:
        raise ConfigError(setting, text, "HOST or HOST:PORT, such as finger.example.org:79")
    return FingerServer(found["host"].strip("[]"), port)


def finger_account(text: str) -> tuple[str, FingerServer]:
    """Read ``login@HOST`` or ``login@HOST:PORT``.

    Raises:
        ConfigError: it is neither.
    """
    login, at, host = text.strip().partition("@")
    if not at or not _USER.fullmatch(login):
        raise ConfigError("finger", text, "login@HOST or login@HOST:PORT")
    return login, finger_server(host, setting="finger")


async def finger(
    user: str, server: FingerServer, *, patience: float = PATIENCE, most: int = MOST_BYTES
) -> str | None:
    """What a server says of ``user``; None of a name that cannot be asked for.

    Args:
        user: the login name; ``@`` and ``/W`` of the protocol are not for users to send.
        server: where to ask.
        patience: wall seconds for all of it.
        most: bytes of the longest reply that is read.

    Raises:
        FingerError: it cannot be reached, is slow, or says too much.
    """
    if not _USER.fullmatch(user):
        return None
    try:
        async with asyncio.timeout(patience):
            reply = await _exchange(f"{user}\r\n".encode("ascii"), server, most)
    except TimeoutError as error:
        raise FingerError(str(server), f"did not answer within {patience:g} s") from error
    except OSError as error:
        raise FingerError(str(server), f"cannot be asked ({error})") from error
    if len(reply) > most:
        raise FingerError(str(server), f"answered more than {most} bytes")
    return reply.decode("utf-8", errors="replace")


async def _exchange(query: bytes, server: FingerServer, most: int) -> bytes:
    reader, writer = await asyncio.open_connection(server.host, server.port)
    try:
        writer.write(query)
        await writer.drain()
        reply = b""
        while len(reply) <= most and (part := await reader.read(4096)):
            reply += part
        return reply
    finally:
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()

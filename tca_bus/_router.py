"""A Zenoh router hosted in this process."""

from __future__ import annotations

import asyncio
import json
import logging
import re
import socket
from types import TracebackType
from typing import Any, Self

import zenoh

from tca_bus._errors import ConfigError
from tca_bus._options import ENDPOINT_EXPECTED, ENDPOINT_PATTERN
from tca_bus._session import LEASE_MS, NO_SHARED_MEMORY, uninterrupted

logger = logging.getLogger(__name__)

DEFAULT_LISTEN = "tcp/127.0.0.1:7447"

MOST_MESSAGE_BYTES = 16 * 1024 * 1024
"""Bigger messages vanish at the router; the link stays up."""

PORT_TRIES = 5

_TCP = re.compile(r"^tcp/(?P<host>.+):(?P<port>\d+)$")


def router_config(endpoint: str) -> zenoh.Config:
    """The Zenoh configuration of the router: an admin space, bounded messages, and gossip.

    Gossip is how modules with direct links find each other; clients take no part in it.
    """
    settings: dict[str, Any] = {
        "mode": "router",
        "listen": {"endpoints": [endpoint], "exit_on_failure": True},
        "scouting": {
            "delay": 0,
            "multicast": {"enabled": False},
            "gossip": {"enabled": True},
        },
        "timestamping": {"enabled": True},
        "adminspace": {"enabled": True},
        "transport": {
            "unicast": {"accept_timeout": 2000},
            "link": {"tx": {"lease": LEASE_MS}, "rx": {"max_message_size": MOST_MESSAGE_BYTES}},
            "shared_memory": NO_SHARED_MEMORY,
        },
    }
    return zenoh.Config.from_json5(json.dumps(settings))


class Router:
    """A Zenoh router, as an async context manager.

    ``listen`` is a Zenoh endpoint; TCP port 0 picks a free one. ``endpoint`` is where the router
    really listens. Listen beyond loopback only on a network that you trust.

    Raises:
        ConfigError: The endpoint is none, or something listens there already.
    """

    def __init__(self, listen: str = DEFAULT_LISTEN) -> None:
        if not ENDPOINT_PATTERN.fullmatch(listen):
            raise ConfigError("listen endpoint", listen, ENDPOINT_EXPECTED)
        self.listen = listen
        self.endpoint = listen
        self._session: zenoh.Session | None = None

    async def __aenter__(self) -> Self:
        match = _TCP.fullmatch(self.listen)
        if match is None or int(match["port"]) != 0:
            await self._open(self.listen)
        else:
            await self._open_on_free_port(match["host"])
        logger.info("router listens at %s", self.endpoint)
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._session is not None:
            await uninterrupted(asyncio.to_thread(self._session.close))
            self._session = None

    def peers(self) -> list[str]:
        """The Zenoh ids of the sessions that are connected."""
        if self._session is None:
            return []
        return sorted(str(transport.zid) for transport in self._session.info.transports())

    async def _open_on_free_port(self, host: str) -> None:
        # Another process may take the port between the look and the listening.
        for left in reversed(range(PORT_TRIES)):
            try:
                await self._open(f"tcp/{host}:{_free_port(host)}")
            except ConfigError:
                if not left:
                    raise
            else:
                return

    async def _open(self, endpoint: str) -> None:
        opening = asyncio.ensure_future(asyncio.to_thread(zenoh.open, router_config(endpoint)))
        try:
            self._session = await asyncio.shield(opening)
        except asyncio.CancelledError:
            await asyncio.wait([opening])
            if opening.exception() is None:
                await asyncio.to_thread(opening.result().close)
            raise
        except zenoh.ZError as error:
            expected = (
                "a free endpoint of this machine; perhaps something listens there already, such "
                "as another 'tca router' or 'rogue up'. Stop it, use it, or choose another with "
                "--connect"
            )
            raise ConfigError("listen endpoint", endpoint, expected) from error
        self.endpoint = endpoint


def _free_port(host: str) -> int:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family) as probe:
        probe.bind((host.strip("[]"), 0))
        port: int = probe.getsockname()[1]
        return port

"""A Zenoh router hosted in this process."""

from __future__ import annotations

import asyncio
import json
import logging
import re
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import zenoh
from zenoh.handlers import Callback

from tca_bus._access import IdentifiedBy, access_control, rate_limits, size_limits
from tca_bus._bridge import call_on
from tca_bus._credentials import Auth, router_transport, usual_auth
from tca_bus._errors import ConfigError
from tca_bus._joining import LEASE, NO_SHARED_MEMORY
from tca_bus._limits import MOST_MESSAGE_BYTES
from tca_bus._lingering import PromptClosing
from tca_bus._options import ENDPOINT_EXPECTED, ENDPOINT_PATTERN, BusOptions
from tca_bus._policy import Policy
from tca_bus._policy_link import serve_policy
from tca_bus._uninterrupted import uninterrupted

logger = logging.getLogger(__name__)

DEFAULT_LISTEN = "tcp/127.0.0.1:7447"

MOST_SESSIONS = 10_000
"""Zenoh's own limit of 1,000 would leave out a thousandth module, and central with it."""

MOST_PENDING = 1000
"""Handshakes under way. Beyond Zenoh's own 100 it shuts the door without a word, which a crowd that
starts together on a busy machine would take for a refusal."""

LINK_RETRY = {"period_init_ms": 200, "period_max_ms": 200, "period_increase_factor": 1}
"""How a lost link to another router is opened again. Routers count anew which way leads where
100 ms after a change; one that came back sooner would be taken for the one before, and never be
told of the tokens beyond the link."""

LINK_TIMEOUT = 0.4
"""Wall seconds for one try to open a link: four round trips of 100 ms. The kernel sends what was
lost again after 1, 2, 4, 8 s; a try that began while the link was cut would outlast its healing."""

SHORTEST_LINK_TIMEOUT, LONGEST_LINK_TIMEOUT = 0.05, 60.0

PORT_TRIES = 5

_HAS_PORT = re.compile(r"^(?P<protocol>tcp|tls|quic|ws)/(?P<host>.+):(?P<port>\d+)$")

IDENTIFIED_BY: dict[Auth, IdentifiedBy] = {
    "certificate": "cert_common_names",
    "password": "usernames",
}


@dataclass(frozen=True, slots=True)
class Guard:
    """Whom a router lets in, and to do what.

    ``keys`` is a folder of 'tca keys'; ``policy`` says who may do what on ``realm``, None that
    all who are let in may do everything; ``auth`` is how they prove who they are: by their
    certificates unless the endpoint is not encrypted.
    """

    keys: Path
    policy: Policy | None = None
    realm: str = BusOptions.model_fields["realm"].default
    auth: Auth | None = None

    def settings(self, endpoint: str) -> dict[str, Any]:
        """The tables of Zenoh's configuration.

        Raises:
            ConfigError: The folder has not what is needed.
        """
        auth = self.auth or usual_auth(endpoint)
        by = IDENTIFIED_BY[auth]
        tables: dict[str, Any] = {"transport": router_transport(self.keys, endpoint, auth)}
        if self.policy is not None:
            tables["access_control"] = access_control(self.policy, self.realm, by=by)
            tables["low_pass_filter"] = size_limits(self.policy, self.realm)
            tables["downsampling"] = rate_limits(self.policy, self.realm)
        return tables


def router_settings(
    endpoint: str,
    guard: Guard | None = None,
    links: Sequence[str] = (),
    *,
    link_timeout: float = LINK_TIMEOUT,
) -> dict[str, Any]:
    """The Zenoh configuration of the router: an admin space, bounded messages, and gossip.

    Gossip is how modules with direct links find each other; clients take no part in it.
    It connects to the routers at ``links``, whenever they can be reached.
    """
    guarded = guard.settings(endpoint) if guard is not None else {"transport": {"link": {}}}
    transport = guarded.pop("transport")
    link = transport.pop("link")
    return {
        "mode": "router",
        "listen": {"endpoints": [endpoint], "exit_on_failure": True},
        "connect": {
            "endpoints": list(links),
            "timeout_ms": -1,
            "exit_on_failure": False,
            "retry": LINK_RETRY,
        },
        "scouting": {
            "delay": 0,
            "multicast": {"enabled": False},
            "gossip": {"enabled": guard is None},
        },
        "timestamping": {"enabled": True},
        "adminspace": {"enabled": True},
        "transport": {
            "unicast": {
                "open_timeout": round(link_timeout * 1000),
                "accept_timeout": 2000,
                "accept_pending": MOST_PENDING,
                "max_sessions": MOST_SESSIONS,
            },
            "link": {
                "tx": LEASE,
                "rx": {"max_message_size": MOST_MESSAGE_BYTES},
                **link,
            },
            "shared_memory": NO_SHARED_MEMORY,
            **transport,
        },
        **guarded,
    }


class Router:
    """A Zenoh router, as an async context manager.

    ``listen`` is a Zenoh endpoint; port 0 picks a free one. ``endpoint`` is where the router
    really listens. Without a ``guard`` anybody who reaches it may do anything: listen beyond
    loopback only with one, or on a network that you trust.

    ``links`` are the endpoints of other routers, on other hosts, with which it makes one bus. It
    starts without them, connects when they are there, and again after each loss; one of two
    routers has to name the other. ``link_timeout`` is how many wall seconds one try may take: give
    links with round trips beyond 100 ms more, at the price that a healed one is back later.

    Raises:
        ConfigError: An endpoint is none, or something listens there already, or the keys of the
            guard cannot be used, or there are both a guard and links, or the timeout is out of
            its range.
    """

    def __init__(
        self,
        listen: str = DEFAULT_LISTEN,
        *,
        guard: Guard | None = None,
        links: Sequence[str] = (),
        link_timeout: float = LINK_TIMEOUT,
    ) -> None:
        for name, endpoint in [("listen endpoint", listen), *(("--link", link) for link in links)]:
            if not ENDPOINT_PATTERN.fullmatch(endpoint):
                raise ConfigError(name, endpoint, ENDPOINT_EXPECTED)
        if guard is not None and links:
            expected = "none for a router with keys: its rules know modules, not other routers"
            raise ConfigError("--link", ", ".join(links), expected)
        if not SHORTEST_LINK_TIMEOUT <= link_timeout <= LONGEST_LINK_TIMEOUT:
            expected = f"{SHORTEST_LINK_TIMEOUT:g} to {LONGEST_LINK_TIMEOUT:g} seconds"
            raise ConfigError("--link-timeout", link_timeout, expected)
        self.listen = listen
        self.links = tuple(links)
        self.link_timeout = link_timeout
        self.endpoint = listen
        self.guard = guard
        self._session: zenoh.Session | None = None
        self._closing: PromptClosing | None = None

    async def __aenter__(self) -> Self:
        match = _HAS_PORT.fullmatch(self.listen)
        if match is None or int(match["port"]) != 0:
            await self._open(self.listen)
        else:
            await self._open_on_free_port(match["protocol"], match["host"])
        logger.info("router listens at %s", self.endpoint)
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._closing is not None:
            self._closing.end()
            self._closing = None
        if self._session is not None:
            await uninterrupted(asyncio.to_thread(self._session.close))
            self._session = None

    def peers(self) -> list[str]:
        """The Zenoh ids of the sessions that are connected."""
        if self._session is None:
            return []
        return sorted(str(transport.zid) for transport in self._session.info.transports())

    async def _open_on_free_port(self, protocol: str, host: str) -> None:
        # Another process may take the port between the look and the listening.
        for left in reversed(range(PORT_TRIES)):
            try:
                await self._open(f"{protocol}/{host}:{_free_port(host)}")
            except ConfigError:
                if not left:
                    raise
            else:
                return

    async def _open(self, endpoint: str) -> None:
        settings = router_settings(endpoint, self.guard, self.links, link_timeout=self.link_timeout)
        config = zenoh.Config.from_json5(json.dumps(settings))
        opening = asyncio.ensure_future(asyncio.to_thread(zenoh.open, config))
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
        self._close_links_promptly(self._session)
        if self.guard is not None:
            serve_policy(self._session, self.guard.policy)
        self.endpoint = endpoint

    def _close_links_promptly(self, session: zenoh.Session) -> None:
        loop, closing = asyncio.get_running_loop(), PromptClosing()

        def changed(event: zenoh.TransportEvent) -> None:
            if event.kind == zenoh.SampleKind.PUT:
                call_on(loop, closing.link_opened)

        session.info.declare_transport_events_listener(Callback(changed), history=False)
        self._closing = closing


def _free_port(host: str) -> int:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family) as probe:
        probe.bind((host.strip("[]"), 0))
        port: int = probe.getsockname()[1]
        return port

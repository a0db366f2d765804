"""Zenoh's configuration of one who joins: a client of a router, or a peer with direct links."""

from __future__ import annotations

import json
import re
from typing import Any

import zenoh

from tca_bus._credentials import credentials_for
from tca_bus._errors import ConfigError
from tca_bus._options import BusOptions

OPEN_SLICE_MS = 500
"""One try to open; a cancelled module waits for at most this long."""

OPEN_TIMEOUT_MS = 10_000
"""Zenoh's own limit to one handshake. Beyond this host each try has `OPEN_SLICE_MS`: the kernel
sends what was lost again after 1, 2, 4, 8 s, so one that began while the network was cut would go
on long after it is healed."""

RETRY = {"period_init_ms": 100, "period_max_ms": 250, "period_increase_factor": 2}
"""How a lost link is opened again; presence counts on four tries a second."""

LEASE_MS, KEEP_ALIVES = 1800, 6
"""A peer that said nothing for so long is taken for gone by the other side; in that time it says
something so many times. The kernel repeats what was lost after 0.2, 0.6, 1.4 and 3 s; the lease
outlasts the third, so that a link healed before it goes on, and one healed later is over soon."""

LEASE = {"lease": LEASE_MS, "keep_alive": KEEP_ALIVES}

PATIENT_LEASE = {"lease": 10_000, "keep_alive": 4}
"""Of a session that many modules of this host share: they keep a machine busy for long when they
start, and the end of a process is seen without a lease."""

NO_SHARED_MEMORY = {"enabled": False}
"""Our messages are small, and a killed process would leave its pool of 16 MB in /dev/shm."""

LOOPBACK = "tcp/127.0.0.1:0"
"""Where a module with direct links listens: on a free port of this host only."""

_ON_THIS_HOST = re.compile(r"^unixsock-stream/|^[a-z]+/(127\.|localhost:|\[::1\]:)")


def session_config(options: BusOptions, module: str = "", *, once: bool = False) -> zenoh.Config:
    """The Zenoh configuration of a module: of a client, or of a peer when links are direct.

    With ``once`` it tries to connect once and does not wait for long.
    """
    if options.is_direct:
        return peer_config(options)
    return client_config(options, module, once=once)


def client_config(options: BusOptions, module: str = "", *, once: bool = False) -> zenoh.Config:
    """The Zenoh configuration of a client of one router, without discovery."""
    settings = {"mode": "client"} | _scouting(gossip=False)
    return _config(options, settings, module, once=once)


def peer_config(options: BusOptions) -> zenoh.Config:
    """The Zenoh configuration of a peer, which learns from the router where the others listen."""
    listening = {"mode": "peer", "listen": {"endpoints": [LOOPBACK], "exit_on_failure": True}}
    return _config(options, listening | _scouting(gossip=True))


def _scouting(*, gossip: bool) -> dict[str, Any]:
    methods = {"multicast": {"enabled": False}, "gossip": {"enabled": gossip}}
    return {"scouting": {"delay": 0, **methods}}


def _config(
    options: BusOptions, settings: dict[str, Any], module: str = "", *, once: bool = False
) -> zenoh.Config:
    credentials = credentials_for(options, module).transport
    common: dict[str, Any] = {
        "connect": {
            "endpoints": [options.connect],
            "timeout_ms": 0 if once else OPEN_SLICE_MS,
            "exit_on_failure": True,
            "retry": RETRY,
        },
        "timestamping": {"enabled": True},
        "transport": {
            **credentials,
            "link": {"tx": _lease(options), **credentials["link"]},
            "shared_memory": NO_SHARED_MEMORY,
            "unicast": {
                "open_timeout": OPEN_SLICE_MS if once or _is_beyond(options) else OPEN_TIMEOUT_MS
            },
        },
    }
    try:
        return zenoh.Config.from_json5(json.dumps(settings | common))
    except zenoh.ZError as error:
        raise ConfigError("--connect", options.connect, f"a Zenoh endpoint ({error})") from error


def _lease(options: BusOptions) -> dict[str, int]:
    return PATIENT_LEASE if options.is_shared and not _is_beyond(options) else LEASE


def _is_beyond(options: BusOptions) -> bool:
    """Whether a network lies between this process and its router."""
    return _ON_THIS_HOST.match(options.connect) is None

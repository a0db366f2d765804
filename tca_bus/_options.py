"""What a module needs to know to join the bus."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    SecretStr,
    ValidationError,
    field_validator,
    model_validator,
)

from tca_bus._errors import ConfigError

CHUNK_PATTERN = re.compile(r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$")
"""A module or realm name: one chunk of a Zenoh key, without wildcards."""

ENDPOINT_PATTERN = re.compile(r"^(tcp|tls|quic|udp|ws)/[^\s/]+:\d{1,5}$|^unixsock-stream/\S+$")
"""A Zenoh endpoint: protocol, slash, address."""

CHUNK_EXPECTED = "1 to 100 letters, digits, '.', '_' or '-', beginning with a letter or digit"
ENDPOINT_EXPECTED = "a Zenoh endpoint such as tcp/127.0.0.1:7447"


class BusOptions(BaseModel):
    """How to join the bus.

    ``connect`` is the router's Zenoh endpoint, ``realm`` the first chunk of all keys,
    ``connect_timeout`` the wall seconds to wait for a router, ``clock`` what `Module.clock`
    follows: the wall, or the simulated time that the robot broadcasts. ``links`` says how messages
    travel: through the router, or directly between modules that all chose so; see
    docs/benchmarks.md for what that gains and costs. With ``ordered`` a module is handed all that
    comes in the order of its coming, whatever its type; one on simulated time always is. With a
    ``shared`` session, modules of one event loop that ``connect`` to the same router have one
    connection to it and its threads in common, as hundreds in one process should.

    ``keys`` is a folder of 'tca keys', from which a module takes what is there for its name: a
    certificate on an encrypted endpoint, a password elsewhere. ``user`` and ``password`` go
    before it.

    Raises:
        ConfigError: A value cannot be used; it names the option and what was expected.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    connect: str = "tcp/127.0.0.1:7447"
    realm: str = "xavier"
    connect_timeout: float = 5.0
    clock: Literal["wall", "sim"] = "wall"
    keys: Path | None = None
    user: str | None = None
    password: SecretStr | None = None
    links: Literal["router", "direct"] = "router"
    ordered: bool = False
    session: Literal["own", "shared"] = "own"

    @property
    def is_shared(self) -> bool:
        """Whether modules of one process have their Zenoh session in common."""
        return self.session == "shared"

    @property
    def is_direct(self) -> bool:
        """Whether modules are linked to each other."""
        return self.links == "direct"

    @property
    def keeps_order(self) -> bool:
        """Whether messages of different types keep their order on the way to the handlers."""
        return self.ordered or self.clock == "sim"

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise _as_config_error(error) from error

    @field_validator("connect")
    @classmethod
    def _check_endpoint(cls, value: str) -> str:
        if not ENDPOINT_PATTERN.fullmatch(value):
            raise ValueError(ENDPOINT_EXPECTED)
        return value

    @field_validator("realm")
    @classmethod
    def _check_realm(cls, value: str) -> str:
        if not CHUNK_PATTERN.fullmatch(value):
            raise ValueError(CHUNK_EXPECTED)
        return value

    @field_validator("connect_timeout")
    @classmethod
    def _check_timeout(cls, value: float) -> float:
        if not 0 < value < float("inf"):
            raise ValueError("a positive number of seconds")
        return value

    @model_validator(mode="after")
    def _check_user(self) -> Self:
        if (self.user is None) != (self.password is None):
            raise ValueError("user and password both, or neither")
        return self

    @model_validator(mode="after")
    def _check_links(self) -> Self:
        if self.is_direct and (self.keys is not None or self.user is not None):
            raise ValueError("links through the router with keys: direct ones pass its rules by")
        return self

    @model_validator(mode="after")
    def _check_session(self) -> Self:
        if self.is_shared and (self.keys is not None or self.user is not None):
            raise ValueError("a session of its own with keys: the router knows a module by it")
        if self.is_shared and self.is_direct:
            raise ValueError("a session of its own with direct links: each pair of modules has one")
        return self


def _as_config_error(error: ValidationError) -> ConfigError:
    problem = error.errors()[0]
    option = ".".join(str(part) for part in problem["loc"]) or "options"
    expected = problem["msg"].removeprefix("Value error, ")
    if problem["type"] == "extra_forbidden":
        expected = f"one of the options {', '.join(BusOptions.model_fields)}"
    return ConfigError(option, problem["input"], expected)

"""With what a module or a router proves who it is, as Zenoh's configuration wants it."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from tca_bus._errors import ConfigError
from tca_bus._keyring import KeyPair, Keyring
from tca_bus._options import BusOptions

ENCRYPTED = ("tls/", "quic/")

Auth = Literal["certificate", "password"]
"""How a router knows who joins."""


@dataclass(frozen=True)
class Credentials:
    """What a session brings: files of certificates, or a user and a password.

    ``transport`` goes into the table of that name in Zenoh's configuration.
    """

    authority: Path | None = None
    pair: KeyPair | None = None
    user: str | None = None
    password: str = field(default="", repr=False)

    @property
    def transport(self) -> dict[str, Any]:
        """The tables ``link.tls`` and ``auth.usrpwd``."""
        tables: dict[str, Any] = {"link": {}}
        if self.authority is not None:
            tables["link"]["tls"] = {"root_ca_certificate": str(self.authority)}
        if self.pair is not None:
            tables["link"]["tls"] |= {
                "enable_mtls": True,
                "connect_certificate": str(self.pair.certificate),
                "connect_private_key": str(self.pair.private_key),
            }
        if self.user is not None:
            tables["auth"] = {"usrpwd": {"user": self.user, "password": self.password}}
        return tables

    @property
    def is_given(self) -> bool:
        """Whether there are any."""
        return self.pair is not None or self.user is not None

    def __str__(self) -> str:
        if self.pair is not None:
            return f"certificate {self.pair.certificate}"
        return f"user {self.user!r}" if self.user is not None else "neither certificate nor user"


def credentials_for(options: BusOptions, module: str) -> Credentials:
    """What a module joins with; the options name a folder of keys, or user and password.

    On an encrypted endpoint a certificate is used if the folder has one for the module, else
    its password.

    Raises:
        ConfigError: The endpoint needs keys and none are named, or they are not there.
    """
    encrypted = options.connect.startswith(ENCRYPTED)
    if options.keys is None:
        if encrypted:
            expected = f"a folder of keys, since {options.connect} is encrypted ('tca keys make')"
            raise ConfigError("--keys", None, expected)
        return Credentials(user=options.user, password=_given(options))
    ring = Keyring(options.keys)
    authority = ring.check_public(ring.authority.certificate) if encrypted else None
    if options.user is not None:
        return Credentials(authority, user=options.user, password=_given(options))
    owner = ring.owner_of(module)
    if encrypted and ring.module(owner).certificate.exists():
        pair = ring.module(owner)
        ring.check_private(pair.private_key)
        return Credentials(authority, pair)
    if not encrypted and not ring.password_file(owner).exists():
        expected = (
            f"one with a password for {owner!r} ('tca keys password'), since {options.connect} is "
            "not encrypted; certificates are for an endpoint tls/HOST:PORT"
        )
        raise ConfigError("--keys", str(options.keys), expected)
    return Credentials(authority, user=owner, password=ring.read_password(owner))


def router_transport(keys: Path, endpoint: str, auth: Auth) -> dict[str, Any]:
    """The tables ``link.tls`` and ``auth.usrpwd`` of a router.

    Raises:
        ConfigError: The folder has not what is needed, or certificates cannot be asked for on
            the endpoint.
    """
    ring = Keyring(keys)
    encrypted = endpoint.startswith(ENCRYPTED)
    if auth == "certificate" and not encrypted:
        raise ConfigError("--auth", auth, f"password on {endpoint}, or an endpoint tls/HOST:PORT")
    tables: dict[str, Any] = {"link": {}}
    if encrypted:
        ring.check_private(ring.router.private_key)
        tables["link"]["tls"] = {
            "enable_mtls": auth == "certificate",
            "root_ca_certificate": str(ring.check_public(ring.authority.certificate)),
            "listen_certificate": str(ring.check_public(ring.router.certificate)),
            "listen_private_key": str(ring.router.private_key),
        }
    if auth == "password":
        ring.read_users()
        tables["auth"] = {"usrpwd": {"dictionary_file": str(ring.users), **_unknown_user()}}
    return tables


def usual_auth(endpoint: str) -> Auth:
    """How a router at an endpoint knows who joins, unless told otherwise."""
    return "certificate" if endpoint.startswith(ENCRYPTED) else "password"


def _unknown_user() -> dict[str, str]:
    """Zenoh wants a router to have a name of its own; nobody knows this one."""
    return {"user": "router", "password": secrets.token_urlsafe(24)}


def _given(options: BusOptions) -> str:
    return options.password.get_secret_value() if options.password is not None else ""

"""Keys for a guarded office, made when it is started for the first time."""

from __future__ import annotations

import datetime as dt
from pathlib import Path
from typing import TYPE_CHECKING

from tca_bus._keyring import Keyring
from tca_bus._policy import CENTRAL
from tca_bus._policy_file import read_policy

if TYPE_CHECKING:
    from tca_bus._authority import Authority

RENEWED_BEFORE = dt.timedelta(days=30)
"""Certificates that end sooner are made anew."""


def provide_keys(folder: Path, policy: Path) -> None:
    """Make in a folder the keys that the modules of a policy file need and have not got.

    A folder without an authority gets one. What is about to expire is renewed.

    Raises:
        ConfigError: The policy cannot be read, or the folder not be written.
    """
    from tca_bus._authority import Authority  # noqa: PLC0415 - most offices need no cryptography

    modules = [CENTRAL, *read_policy(policy).modules]
    fresh = not Keyring(folder).authority.certificate.exists()
    authority = Authority.make(folder) if fresh else Authority(folder)
    for name in modules:
        if not authority.keyring.module(name).certificate.exists():
            authority.add_module(name)
    _renew(authority)


def _renew(authority: Authority) -> None:
    soon = dt.datetime.now(dt.UTC) + RENEWED_BEFORE
    infos = [info for info in authority.list() if info.kind != "authority"]
    ending = [info.name for info in infos if info.expires is not None and info.expires < soon]
    if ending:
        authority.renew(ending)

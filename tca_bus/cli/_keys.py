"""``tca keys``: a small certificate authority, and the keys with which modules join."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter
from cyclopts.validators import Number

from tca_bus._errors import ConfigError
from tca_bus._keyring import Keyring
from tca_bus._policy import CENTRAL
from tca_bus._policy_file import read_policy
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, show_table

if TYPE_CHECKING:
    from tca_bus._authority import Authority, KeyInfo

YEAR = 365

Days = Annotated[int, Parameter(validator=Number(gte=1, lte=3650))]
Hosts = Annotated[list[str] | None, Parameter(name="--host", negative="")]

keys_app = App(
    name="keys",
    help_format="markdown",
)


@keys_app.command
def make(
    folder: Path,
    /,
    *modules: str,
    host: Hosts = None,
    policy: Path | None = None,
    days: Days = YEAR,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Make an authority in a new folder, with keys for the router, central and some modules.

    Parameters
    ----------
    folder
        Where the keys are put; private ones are readable by their owner only.
    modules
        Names of modules.
    host
        Name or address at which others reach the router, beside this machine's own and loopback;
        may be repeated.
    policy
        Policy file; its modules get keys too.
    days
        How long the certificates are valid.
    """
    from tca_bus._authority import Authority  # noqa: PLC0415 - other commands need no cryptography

    listed = read_policy(policy).modules if policy is not None else ()
    authority = Authority.make(folder, hosts=host or (), days=days)
    for name in dict.fromkeys([CENTRAL, *modules, *listed]):
        authority.add_module(name, days=days)
    _show(authority.keyring, flags)


@keys_app.command
def add(
    folder: Path,
    /,
    *modules: str,
    days: Days = YEAR,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Make keys for more modules, signed by the authority in a folder.

    Parameters
    ----------
    folder
        A folder of 'tca keys make'.
    modules
        Names of modules that have no keys yet.
    days
        How long the certificates are valid.
    """
    authority = _authority(folder)
    for name in _some(modules):
        authority.add_module(name, days=days)
    _show(authority.keyring, flags)


@keys_app.command
def password(folder: Path, /, *modules: str, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Make passwords for modules: they are enough where nobody can listen in.

    Parameters
    ----------
    folder
        A folder of 'tca keys make'.
    modules
        Names of modules that have no password yet.
    """
    authority = _authority(folder)
    for name in _some(modules):
        authority.add_password(name)
    _show(authority.keyring, flags)


@keys_app.command
def renew(
    folder: Path,
    /,
    *names: str,
    host: Hosts = None,
    days: Days = YEAR,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Make new keys and certificates in place of old ones, of the router and all modules.

    Parameters
    ----------
    folder
        A folder of 'tca keys make'.
    names
        Only these: router, or names of modules.
    host
        Name or address of the router that its certificate is to have beside those of before.
    days
        How long the new certificates are valid.
    """
    authority = _authority(folder)
    authority.renew(names, days=days, hosts=host or ())
    _show(authority.keyring, flags)


@keys_app.command(name="list")
def list_(folder: Path, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """List the keys in a folder: whose they are and until when they are valid.

    Parameters
    ----------
    folder
        A folder of 'tca keys make'.
    """
    _show(Keyring(folder), flags)


def _authority(folder: Path) -> Authority:
    from tca_bus._authority import Authority  # noqa: PLC0415 - other commands need no cryptography

    return Authority(folder)


def _some(modules: Sequence[str]) -> Sequence[str]:
    if not modules:
        raise ConfigError("modules", "", "at least one name of a module")
    return modules


def _show(ring: Keyring, flags: BusFlags) -> None:
    from tca_bus._authority import list_keys  # noqa: PLC0415 - other commands need no cryptography

    rows = [_row(info) for info in list_keys(ring)]
    if flags.json:
        emit_json(rows)
        return
    show_table(("name", "kind", "expires", "days", "password", "hosts"), map(_cells, rows))
    emit(f"in {ring.folder}")


def _row(info: KeyInfo) -> dict[str, Any]:
    left = None if info.expires is None else (info.expires - dt.datetime.now(dt.UTC)).days
    return {
        "name": info.name,
        "kind": info.kind,
        "expires": None if info.expires is None else info.expires.date().isoformat(),
        "days": left,
        "password": info.has_password,
        "hosts": list(info.hosts),
    }


def _cells(row: dict[str, Any]) -> tuple[object, ...]:
    return (*list(row.values())[:4], "yes" if row["password"] else "", ", ".join(row["hosts"]))

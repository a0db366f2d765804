"""A small office behind TLS, for the tests of who may do what."""

from __future__ import annotations

import dataclasses
from contextlib import asynccontextmanager

from pydantic import BaseModel

from tca_bus import Broadcast, BusOptions, Command, Goal, Inform, Module, MultiQuery, Query, Router
from tca_bus._authority import Authority
from tca_bus._central import Central
from tca_bus._permissions import Permissions
from tca_bus._policy import Policy
from tca_bus._router import Guard

REALM = "guarded"


class Sum(BaseModel):
    value: int


class Add(Query[Sum]):
    a: int
    b: int


class Secret(Query[str]):
    pass


class Survey(MultiQuery[str]):
    pass


class Note(Inform):
    text: str = ""


class Scan(Broadcast):
    text: str = ""


class Drive(Command[str]):
    where: str = "here"


class Plan(Goal[str]):
    pass


@dataclasses.dataclass(frozen=True)
class Office:
    """A guarded router; ``policy`` is what it goes by."""

    router: Router
    keys: object
    policy: Policy

    def options(self, **changes):
        values = {
            "connect": self.router.endpoint,
            "realm": REALM,
            "keys": self.keys,
            "connect_timeout": 10.0,
        }
        return BusOptions(**(values | changes))

    def module(self, name, **changes):
        return Module(name, options=self.options(**changes))


@asynccontextmanager
async def guarded(keys, policy, *, endpoint="tls/127.0.0.1:0", auth=None):
    parsed = Policy.model_validate(policy)
    guard = Guard(keys, parsed, REALM, auth)
    async with Router(endpoint, guard=guard) as router:
        yield Office(router, keys, parsed)


@asynccontextmanager
async def with_central(keys, policy, **options):
    async with guarded(keys, policy, **options) as office, Central(office.options()) as running:
        yield office, running


class Lax(Permissions):
    """What a module has that was written by somebody who does not care for the policy."""

    def __init__(self):
        super().__init__(None)
        self.is_fixed = True


def careless(module):
    """Have a module ask nobody before it acts."""
    module.permissions = Lax()
    return module


def make_keys(folder, *modules, passwords=()):
    authority = Authority.make(folder)
    for name in ("central", *modules):
        authority.add_module(name)
    for name in passwords:
        authority.add_password(name)
    return folder

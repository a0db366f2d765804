"""How a module learns who may do what: it asks the router, before it does anything else.

What a router's rules forbid vanishes without a word, so each module asks the policy itself
before it sends. The router answers on two keys: the one with a module's name can be asked only
by that module, the one without by everybody who is let in. So a module that gets the second
answer and not the first has joined under a name that is not its own.
"""

from __future__ import annotations

import asyncio
import json
import logging
import time

import zenoh
from pydantic import ValidationError
from zenoh.handlers import Callback

from tca_bus._errors import InvalidMessageError, RefusedError
from tca_bus._keys import Keys
from tca_bus._policy import Policy, parse_policy
from tca_bus._problems import problems_of
from tca_bus._session import Session
from tca_bus._wire import Payload

logger = logging.getLogger(__name__)

ENCODING = "application/json;tca.policy@1"

ASK_TIMEOUT = 2.0
"""Wall seconds that one question to the router may take."""

PATIENCE = 1.0
"""Wall seconds in which a router that has just started begins to answer."""

RETRY_DELAY = 0.02

UNHEARD = (
    "the router at %s tells no policy for realm %r; a 'tca router' whose policy is for another "
    "realm drops everything (--realm)"
)

NO_POLICY = b"null"
SOME_POLICY = b'"ask by your name"'

ALL_KEYS = ("*/policy", "*/policy/*")


def serve_policy(session: zenoh.Session, policy: Policy | None) -> None:
    """Answer modules that ask for the policy, from the session of a router."""
    told = NO_POLICY if policy is None else policy.model_dump_json().encode()
    public = NO_POLICY if policy is None else SOME_POLICY

    def answer(query: zenoh.Query) -> None:
        with query:
            payload = told if str(query.key_expr).count("/") > 1 else public
            query.reply(query.key_expr, payload, encoding=ENCODING)

    for key in ALL_KEYS:
        session.declare_queryable(key, Callback(answer, indirect=True))


async def fetch_policy(
    session: Session, keys: Keys, module: str, *, default: Policy | None
) -> Policy | None:
    """The policy of the router, None when it has none; ``default`` when it does not say.

    Raises:
        RefusedError: The policy does not know the module, or not under these keys.
        InvalidMessageError: The router's policy is of another version than this program.
    """
    deadline = time.monotonic() + PATIENCE
    while True:
        answer = await _ask(session, keys.policy(module))
        if answer is not None:
            return _known(answer)
        public = await _ask(session, keys.policy())
        if public == NO_POLICY:
            return None
        if public is not None:
            raise _stranger(session, module)
        if time.monotonic() >= deadline:
            if default is None:
                logger.warning(UNHEARD, session.endpoint, keys.realm)
            return default
        await asyncio.sleep(RETRY_DELAY)


async def _ask(session: Session, key: str) -> bytes | None:
    try:
        answer = await session.ask(key, Payload(b"", ""), attachment=b"", timeout=ASK_TIMEOUT)
    except TimeoutError:
        return None
    return None if answer is None or answer.is_error else answer.payload.data


def _known(answer: bytes) -> Policy | None:
    data = json.loads(answer)
    if data is None:
        return None
    try:
        policy = parse_policy(data)
    except ValidationError as error:
        raise InvalidMessageError("policy", problems_of(error)) from error
    return policy


def _stranger(session: Session, module: str) -> RefusedError:
    why = (
        f"the router's policy does not let it take this name with {session.credentials}; "
        "a name must be listed under 'modules' and be that of the certificate or user"
    )
    return RefusedError(f"joining the bus at {session.endpoint} as {module!r}", why)

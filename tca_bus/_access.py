"""Turns a policy into the access rules of a Zenoh router.

A router knows who is connected by the common name of its certificate, or by its user name, and
sees the keys of messages, which name who sends. So the rules bind the one to the other. They are
made from the families of keys in `tca_bus._keys`; what only central knows (tasks, resources,
variables) is for central to check.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from tca_bus._keyring import owner_among
from tca_bus._keys import FAMILIES, Family, Traffic
from tca_bus._limits import ENVELOPE_BYTES
from tca_bus._policy import CENTRAL, FROM_CENTRAL, GUARDED, Policy
from tca_bus._rights import BUS_PREFIX, Right, as_chunk, as_module_chunks

IdentifiedBy = Literal["cert_common_names", "usernames"]
"""What a router knows a module by."""

ALL = "@all"
"""The subject that everybody who is connected belongs to."""

IN = "ingress"
OUT = "egress"

ANY_BUS_NAME = f"{BUS_PREFIX}$*"

DECLARATION = {Traffic.ASKED: "declare_queryable", Traffic.PUT: "declare_subscriber"}
CARRIER = {Traffic.ASKED: "query", Traffic.PUT: "put"}

RATE_SLACK = 2.0
"""A router lets messages come this much closer than the sender may send them: on their way the
gaps between them change."""

Messages = tuple[str, ...]
Rule = tuple[Messages, str, str]
"""The kinds of messages, the direction as the router sees it, and the key."""


@dataclass
class _Rules:
    """The rules of one subject, those of one kind and direction gathered."""

    subject: str
    allow: dict[tuple[Messages, str], list[str]] = field(default_factory=dict)
    deny: dict[tuple[Messages, str], list[str]] = field(default_factory=dict)

    def rendered(self) -> Iterator[dict[str, Any]]:
        """The rules as Zenoh wants them."""
        for permission, table in (("allow", self.allow), ("deny", self.deny)):
            for (messages, flow), keys in table.items():
                yield {
                    "id": f"{self.subject} {permission} {flow} {' '.join(messages)}",
                    "permission": permission,
                    "messages": list(messages),
                    "flows": [flow],
                    "key_exprs": list(dict.fromkeys(keys)),
                }


def access_control(policy: Policy | None, realm: str, *, by: IdentifiedBy) -> dict[str, Any]:
    """The ``access_control`` table of a router's configuration.

    Args:
        policy: Who may do what; None for a router that lets all who may join do everything.
        realm: The first chunk of the keys; nothing passes on those of another realm.
        by: What the names of modules are compared with.
    """
    if policy is None:
        return {"enabled": False}
    gathered = [_everyone(realm), _central(realm)]
    gathered += [_module(policy, realm, module) for module in policy.modules]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [rule for rules in gathered for rule in rules.rendered()],
        "subjects": [_subject(rules.subject, by) for rules in gathered],
        "policies": [
            {"rules": [rule["id"] for rule in rules.rendered()], "subjects": [rules.subject]}
            for rules in gathered
        ],
    }


def audible(policy: Policy, module: str) -> list[str]:
    """The keys, without the realm, that a module may subscribe to; the widest that it may."""
    owner = owner_among(module, policy.modules)
    if owner is None:
        return []
    rules = _allowed(policy, owner)
    keys = [key for messages, _, key in rules if "declare_subscriber" in messages]
    return list(dict.fromkeys(["presence/**", *keys]))


def size_limits(policy: Policy, realm: str) -> list[dict[str, Any]]:
    """The ``low_pass_filter`` table: bigger messages do not pass."""
    limits = [(p, limit.bytes) for p, limit in policy.limits.items() if limit.bytes is not None]
    return [
        {
            "id": f"size {pattern}",
            "flows": [IN],
            "messages": ["put", "query"],
            "key_exprs": _limited_keys(realm, pattern),
            "size_limit": most + ENVELOPE_BYTES,
        }
        for pattern, most in limits
    ]


def rate_limits(policy: Policy, realm: str) -> list[dict[str, Any]]:
    """The ``downsampling`` table: more messages in a second do not pass."""
    limits = [(p, limit.hertz) for p, limit in policy.limits.items() if limit.hertz is not None]
    return [
        {
            "id": f"rate {pattern}",
            "flows": [IN],
            "messages": ["put", "query"],
            "rules": [
                {"key_expr": key, "freq": most * RATE_SLACK}
                for key in _limited_keys(realm, pattern)
            ],
        }
        for pattern, most in limits
    ]


def _subject(name: str, by: IdentifiedBy) -> dict[str, Any]:
    return {"id": name} if name == ALL else {"id": name, by: [name]}


def _everyone(realm: str) -> _Rules:
    """Presence, the public word on the policy, and hearing of declarations."""
    presence = [f"{realm}/presence/**"]
    rules = _Rules(ALL)
    rules.allow[("liveliness_query", "declare_liveliness_subscriber"), IN] = presence
    rules.allow[("liveliness_token",), OUT] = presence
    rules.allow[("query",), IN] = [f"{realm}/policy"]
    rules.allow[("reply",), OUT] = [f"{realm}/policy"]
    rules.allow[("declare_queryable", "declare_subscriber"), OUT] = [f"{realm}/**"]
    return rules


def _central(realm: str) -> _Rules:
    everything = [f"{realm}/**"]
    rules = _Rules(CENTRAL)
    rules.allow[("put", "delete", "query", "reply"), IN] = everything
    rules.allow[("put", "delete", "query", "reply"), OUT] = everything
    rules.allow[("declare_queryable", "declare_subscriber"), IN] = everything
    rules.allow[("liveliness_token",), IN] = everything
    return rules


def _module(policy: Policy, realm: str, module: str) -> _Rules:
    rules = _Rules(module)
    for messages, flow, key in _allowed(policy, module):
        rules.allow.setdefault((messages, flow), []).append(f"{realm}/{key}")
    for messages, flow, key in _denied(policy, module):
        rules.deny.setdefault((messages, flow), []).append(f"{realm}/{key}")
    return rules


def _allowed(policy: Policy, module: str) -> Iterator[Rule]:
    for me in _names_of(module):
        yield ("liveliness_token",), IN, f"presence/{me}/**"
        yield ("query",), IN, f"policy/{me}"
        yield ("reply",), OUT, f"policy/{me}"
    for family in FAMILIES:
        if family.traffic == Traffic.PUBLISHED:
            yield from _watching(family, policy, module)
        else:
            yield from _sending(family, policy, module)
            yield from _receiving(family, policy, module)


def _sending(family: Family, policy: Policy, module: str) -> Iterator[Rule]:
    carrier = CARRIER[family.traffic]
    for key in _keys(family, names=_sendable(family, policy, module), sender=_names_of(module)):
        yield (carrier,), IN, key
        if family.traffic == Traffic.ASKED:
            yield ("reply",), OUT, key


def _receiving(family: Family, policy: Policy, module: str) -> Iterator[Rule]:
    receivers = _names_of(module) if "{receiver}" in family.shape else ["*"]
    for names, senders in _receivable(family, policy, module):
        for key in _keys(family, names=names, sender=senders, receiver=receivers):
            yield (CARRIER[family.traffic],), OUT, key
            if family.traffic == Traffic.ASKED:
                yield ("reply",), IN, key
        for key in _declared(family, names, receivers):
            yield (DECLARATION[family.traffic],), IN, key


def _watching(family: Family, policy: Policy, module: str) -> Iterator[Rule]:
    patterns = [p for right in family.needs for p in policy.patterns(module, right)]
    if "{owner}" in family.shape:
        chunks = [*_names_of(module), *(n for p in patterns for n in as_module_chunks(p))]
    else:
        chunks = [as_chunk(p) for p in patterns]
    for chunk in chunks:
        key = family.shape.format(owner=chunk, name=chunk)
        yield ("declare_subscriber", "query"), IN, key
        yield ("put", "delete", "reply"), OUT, key


def _denied(policy: Policy, module: str) -> Iterator[Rule]:
    """Names of the bus that a ``*`` would cover."""
    may_not = [n for n in sorted(GUARDED) if not policy.rule(module, Right.SEND, n)]
    for name in [*sorted(FROM_CENTRAL), *may_not]:
        for family in FAMILIES:
            if family.traffic != Traffic.PUBLISHED and "{name}" in family.shape:
                yield (CARRIER[family.traffic],), IN, next(_keys(family, names=[name]))


def _sendable(family: Family, policy: Policy, module: str) -> list[str]:
    """The names that a module may send; without a name in the key any will do."""
    if "{name}" not in family.shape:
        return ["*"]
    return [ANY_BUS_NAME, *map(as_chunk, policy.patterns(module, Right.SEND))]


def _receivable(
    family: Family, policy: Policy, module: str
) -> Iterator[tuple[Sequence[str], Sequence[str]]]:
    """Names that a module may receive, and from which senders."""
    if "{name}" not in family.shape:
        yield ["*"], ["*"]
        return
    yield [ANY_BUS_NAME], ["*"]
    for right in family.needs:
        for pattern in policy.patterns(module, right):
            name, at, owner = pattern.partition("@")
            yield [as_chunk(name)], as_module_chunks(owner) if at else ["*"]


def _declared(family: Family, names: Sequence[str], receivers: Sequence[str]) -> Iterator[str]:
    """What a receiver declares: all below its own chunk, or a name from all senders."""
    head, receiver, _ = family.shape.partition("{receiver}")
    if receiver:
        yield from (f"{head}{me}/**" for me in receivers)
    else:
        yield from _keys(family, names=names)


def _keys(
    family: Family,
    *,
    names: Iterable[str],
    sender: Sequence[str] = ("*",),
    receiver: Sequence[str] = ("*",),
) -> Iterator[str]:
    for name in names:
        for who in sender:
            for to in receiver:
                yield family.shape.format(name=name, sender=who, receiver=to)


def _limited_keys(realm: str, pattern: str) -> list[str]:
    name, at, owner = pattern.partition("@")
    senders = as_module_chunks(owner) if at else ["*"]
    families = [f for f in FAMILIES if "{name}" in f.shape]
    keys = [key for f in families for key in _keys(f, names=[as_chunk(name)], sender=senders)]
    return [f"{realm}/{key}" for key in keys]


def _names_of(module: str) -> list[str]:
    """The names under which a module may join, as chunks."""
    return [module, f"{module}-$*"]

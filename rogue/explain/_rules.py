"""The rules of the office, and PRODIGY's defaults, in words that a user understands.

Each is the end of a sentence: "... since its room is the nearest". A rule that is not here is
somebody's own, and named as it is.
"""

from __future__ import annotations

from collections.abc import Mapping

RULES: Mapping[str, str] = {
    # PRODIGY's defaults
    "first": "it came up first",
    "only one": "nothing else was possible then",
    "free to go": "it undoes nothing that other steps need",
    "threatened by others": "another step would have undone what it needs",
    "fewest conflicts": "it gets in the way of the fewest other steps",
    # the published rules
    "nearest-room": "its room is the nearest",
    "goto-for-consumer": "it is the kind of drive that the step after it needs",
    "errand-rooms": "that is the room of the errand",
    # both
    "no-premature-goto": "any other drive would have come too early to be of use",
    "item-of-consumer": "it is for the same errand as the step after it",
    # the working rules
    "deliver-goto-for-delivery": "the delivery needs the robot to be there",
    "pickup-goto-for-acquire": "the item is there",
    "deliveries-make-room": "planned deliveries make room on the tray",
    "select-top-priority-and-compatible-goals": "it is the most urgent, or on the way to that",
    "prefer-goals-of-next-stop": "the next stop of the best round needs it",
    "set-out-for-next-stop": "the next stop can be driven to, and the rest is planned on the way",
    "order-of-tour": "it is the next stop of the best round through all rooms",
    "put-off-for-top-priority": "more urgent errands come first",
}


def because(rule: str) -> str:
    """Return why a rule decides as it does, beginning with "since"; "" for no rule."""
    if not rule:
        return ""
    known = RULES.get(rule.lower())
    return f"since {known}" if known else f"as the rule {rule} says"

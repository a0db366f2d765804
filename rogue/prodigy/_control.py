"""Application of control rules to the candidates of a choice."""

from __future__ import annotations

from dataclasses import dataclass

from rogue.prodigy._events import Choice, RuleFired
from rogue.prodigy._rules import Action, Candidate, DecideRule, PreferRule, Rule, RuleSet
from rogue.prodigy._view import SearchView


@dataclass(frozen=True, slots=True)
class Filtered:
    """Candidates left by select and reject rules, and the rules that fired."""

    candidates: tuple[Candidate, ...]
    fired: tuple[RuleFired, ...] = ()

    def explained(self, failure: str) -> str:
        """Return the words for a failure, with the rules that left nothing to choose from."""
        names = dict.fromkeys(f.rule for f in self.fired if f.action == "reject")
        if self.candidates or not names:
            return failure
        rules = "control rule" if len(names) == 1 else "control rules"
        return f"{failure}: all rejected by {rules} {' and '.join(names)}"


def filter_candidates(
    rules: RuleSet, choice: Choice, view: SearchView, candidates: tuple[Candidate, ...]
) -> Filtered:
    """Apply the first select rule that matches, then every reject rule, newest first."""
    fired: list[RuleFired] = []
    for rule in _of(rules, choice, Action.SELECT):
        chosen = rule.speaks_of(view, candidates) if candidates else ()
        if chosen:
            fired.append(RuleFired(rule.name, "select", tuple(map(str, chosen))))
            candidates = chosen
            break
    for rule in _of(rules, choice, Action.REJECT):
        gone = rule.speaks_of(view, candidates) if candidates else ()
        if gone:
            fired.append(RuleFired(rule.name, "reject", tuple(map(str, gone))))
            dropped = {id(c) for c in gone}
            candidates = tuple(c for c in candidates if id(c) not in dropped)
    return Filtered(candidates, tuple(fired))


def prefer_candidate(
    rules: RuleSet, choice: Choice, view: SearchView, candidates: tuple[Candidate, ...]
) -> tuple[Candidate | None, tuple[RuleFired, ...]]:
    """Follow "better than" links from the first candidate until none is better.

    Returns the candidate, None if no rule speaks of the first one, and the rules that fired; a
    cycle is one of them, reported as ``prefer cycle``, and the search goes on with its last.
    """
    preferences = [
        r for r in reversed(rules.rules) if isinstance(r, PreferRule) and r.choice is choice
    ]
    current, seen, fired = candidates[0], {id(candidates[0])}, list[RuleFired]()
    while preferences:
        link = _better(preferences, view, current, candidates)
        if link is None:
            break
        rule, better = link
        if id(better) in seen:
            fired.append(RuleFired(rule.name, "prefer cycle", (str(better), str(current))))
            break
        fired.append(RuleFired(rule.name, "prefer", (str(better), str(current))))
        seen.add(id(better))
        current = better
    return (current if fired else None), tuple(fired)


def _better(
    rules: list[PreferRule],
    view: SearchView,
    current: Candidate,
    candidates: tuple[Candidate, ...],
) -> tuple[PreferRule, Candidate] | None:
    for rule in rules:
        better = rule.preferred(view, current, candidates)
        if better is not None:
            return rule, better
    return None


def decide(rules: RuleSet, view: SearchView) -> tuple[Action, str] | None:
    """Return what the newest matching rule says about applying or sub-goaling."""
    for rule in reversed(rules.rules):
        if isinstance(rule, DecideRule) and rule.test(view):
            return rule.action, rule.name
    return None


def _of(rules: RuleSet, choice: Choice, action: Action) -> list[Rule]:
    mine = [r for r in rules.rules if isinstance(r, Rule)]
    return [r for r in reversed(mine) if r.choice is choice and r.action is action]

"""The grammar of TCA's log, written from the one of its viewer comview (parse.y and parse.l).

Time and ids are optional there, a status is not; keywords are told from names as its scanner
does. ``parse`` gives the tree of a line, or raises `lark.LarkError`.
"""

from __future__ import annotations

from functools import cache

import lark

GRAMMAR = r"""
start: message | answer | reply | retry | fired | asserting | adding | kill | will_kill
     | limit | data

message: (_CLASS | _BYPASS) ref ":" way? STATUS time?
way: place id? "-->" place
answer: _SUCCESS ref ":" time?
      | _FAILURE ref ":" place id? time?
reply: _REPLY ref ":" place "-->" place id? time?
retry: _RETRY ref
fired: _FIRE_DEMON id? ":" place id? "-->" place STATUS time?
asserting: _ASSERTING point RELATION point
point: END INTERVAL words ")" ")" id?
adding: _ADDING CONSTRAINT ref ("and" ref)?
kill: _KILLED ref time?
will_kill: _WILL_KILL ref SITUATION time?
limit: _LIMIT ref time?
data: DATA

ref: words id?
place: RESOURCE? words
words: NAME+
id: "{" INTEGER "}"
time: INTEGER ":" INTEGER ":" INTEGER "." INTEGER

_CLASS.9: /^(Query|Goal|Command|Inform|Constraint|Broadcast|Exception|IMonitor|Monitor|PMonitor)/
_BYPASS.9: /^  ByPass/
_SUCCESS.9: /^  (Success|Done)/
_FAILURE.9: /^  Failure/
_REPLY.9: /^  Reply/
_RETRY.9: /^  Retry/
_FIRE_DEMON.9: /^FireDemon/
_ASSERTING.9: /^   Asserting/
_ADDING.9: /^Adding/
_KILLED.9: /^Killed/
_WILL_KILL.9: /^Will kill/
_LIMIT.9: /^PENDING LIMIT: Deleted message/
DATA.10: /^    .+/
STATUS.8: "(Sent)" | "(Pending)" | "(Inactive)" | "(Completed)"
END.8: "Start(" | "End("
INTERVAL.8: "Planning(" | "Achievement(" | "Handling("
RELATION.8: "<=" | ">=" | "<" | ">" | "="
CONSTRAINT.8: /SEQUENTIAL (ACHIEVEMENT|PLANNING) constraint between/
            | /(DELAY PLANNING|PLAN FIRST) constraint to/
SITUATION.8: "when it completes" | "when submessages complete"
           | "when all references to it are released"
RESOURCE.7: /Resource(?![A-Za-z0-9_*-])/
INTEGER.6: /([0-9]+|-1)(?![A-Za-z0-9_*-])/
NAME.5: /(?!(and|on|Resource|[0-9]+)(?![A-Za-z0-9_*-]))[A-Za-z0-9_*][A-Za-z0-9_*-]*/
%ignore /[ \t]+/
"""


@cache
def _parser() -> lark.Lark:
    return lark.Lark(GRAMMAR, parser="lalr", lexer="contextual")


def parse(line: str) -> lark.Tree:
    return _parser().parse(line)

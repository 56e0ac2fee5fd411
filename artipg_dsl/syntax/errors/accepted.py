"""What the parser would have taken at the token at which it stopped, if that is short; else what is plain from it."""

from __future__ import annotations

import re

from lark import Token, UnexpectedToken

from ...diagnostics.suggest import suggest
from ...records import dataclass
from ...source import Span
from ..grammar import terminal_words
from ..words import OPERATORS, VALUE, file_words, statement_words
from .foreign import CLAUSES_ELSEWHERE
from .found import Found, quoted
from .unclosed import open_bracket

_MEANT_BY_IF = {  # statements with a condition of another word, in which `if` is often meant for it
    "LABEL": "to say where a label holds, write `where` for `if`",
    "FIELD": "to say where a field holds, write `where` for `if`",
    "PART": "to give an alternative a condition, write `when` for `if`",
    "STYLE": "to give an alternative a condition, write `when` for `if`",
    "JOINT": "to let a joint wait for another, write `when` for `if`",
    "REQUIRE": "to require something of some objects alone, put it inside `when ... { }`",
}
_SIGNS = {
    "LBRACE": "`{`",
    "RBRACE": "`}`",
    "LPAR": "`(`",
    "RPAR": "`)`",
    "LSQB": "`[`",
    "RSQB": "`]`",
    "COLON": "`:`",
    "COMMA": "`,`",
    "EQUAL": "`=`",
    "ARROW": "`->`",
    "UNTIL": "`..`",
    "UPTO": "`..<`",
    "DOT": "`.`",
    "BAR": "`|`",
    "NAME": "a name",
    "WORD": "a word",
    "NUMBER": "a number",
    "STRING": "a text in quotes",
    "$END": "the end of the file",
}


@dataclass(frozen=True, slots=True)
class _Stop:
    """The ``token`` at which the parser stopped, the types it would have ``accepted``, and the word of the ``statement`` that it was in."""

    token: Token
    accepted: frozenset[str]
    statement: Token | None
    history: list[Token]
    span: Span

    @property
    def shown(self) -> str:
        return quoted(self.token)

    def within(self, *statements: str) -> bool:
        return self.statement is not None and self.statement.type in statements


def by_accepts(error: UnexpectedToken, history: list[Token], span: Span) -> Found:
    """What the parser would have taken, if that is short; else what is plain from it."""
    statement = next((t for t in reversed(history) if t.type in statement_words() | file_words()), None)
    stop = _Stop(error.token, frozenset(error.accepts or ()) - {"_NL"}, statement, history, span)
    message, hint = _missing(stop) or _astray(stop) or _out_of_place(stop)
    return Found("syntax", span, message, span.start, hint)


def _missing(stop: _Stop) -> tuple[str, str] | None:
    """A value or a sign that is not there, and what to write."""
    token, accepted, shown = stop.token, stop.accepted, stop.shown
    brace = f"`{{` is missing before {shown}", "what belongs to the statement stands in braces: `{ ... }`"
    if accepted >= VALUE:
        hint = "for example a number with its unit, a name or a vector `[x, y, z]`"
        return f"a value is missing before {shown}", hint
    if accepted <= {"LBRACE"}:
        return brace
    if token.type == "COMMA" and re.match(r"\d,\d", stop.span.source.text[stop.span.start - 1 : stop.span.start + 2]):
        return "a number has a decimal point, not a comma", "write it as in `0.5`"
    if "UNTIL" in accepted and len(accepted) <= 4:
        return f"`..` is missing before {shown}", "a range is written `low .. high`"
    if accepted == {"ARROW"} or "ARROW" in accepted and stop.within("JOINT"):
        hint = "`joint name : kind parent -> child`: the part that moves follows the arrow"
        return f"`->` is missing before {shown}", hint
    if "LBRACE" in accepted and token.type == "_NL":
        return brace
    if accepted == {"ELSE"}:
        meant = None
        if stop.statement is not None and open_bracket(stop.history) is None:
            meant = _MEANT_BY_IF.get(stop.statement.type)
        return f"`else` is missing before {shown}", meant or "a value with a condition is written `a if c else b`"
    return None


def _astray(stop: _Stop) -> tuple[str, str] | None:
    """A token that stands where it cannot, and what to do with it; of few that could stand there, which."""
    token, accepted, words = stop.token, stop.accepted, terminal_words()
    if token.type in ("RPAR", "RSQB") and token.type not in accepted:
        return f"{stop.shown} has no matching opening bracket", "remove it, or add the missing bracket before it"
    if stop.within("USE") and token.value == "as":
        return "an import keeps its name", "leave `as` and the other name out"
    if 0 < len(accepted) <= 4:
        names = sorted(_SIGNS.get(a, f"`{words.get(a, a.lower())}`") for a in accepted)
        where = "" if token.type == "_NL" else " before it, or in its place"
        return f"expected {' or '.join(names)}, found {stop.shown}", f"write {names[0]}{where}"
    if stop.statement is None:
        return None
    if token.type == "COMMA":
        hint = "numbers use a decimal point, as in `0.5`; a statement ends at the end of its line"
        return "a comma separates values in brackets, names and targets", hint
    elsewhere = CLAUSES_ELSEWHERE.get((stop.statement.value, token.value))
    return None if elsewhere is None else (f"`{stop.statement.value}` takes no `{token.value}`", elsewhere)


def _out_of_place(stop: _Stop) -> tuple[str, str]:
    """That a token does not belong to its statement, and which clause may be meant."""
    token, statement = stop.token, stop.statement
    if statement is None or not token.value:
        return f"{stop.shown} is not allowed here", "remove it, or begin a new line before it"
    clauses = _clauses(stop)
    near = suggest(token.value, clauses)
    if near is None and token.type == "NAME" and stop.within("LABEL", "MATERIAL", "FIELD"):
        example = "for example `label semantic.leg on left_leg, right_leg`"
        return f"a comma is missing before {stop.shown}: targets are separated by commas", example
    if near:
        hint = f"did you mean `{near}`?"
    elif stop.within("PARAM") and [t.type for t in stop.history[-2:]] == ["COLON", "NAME"]:
        hint = "a range follows `in`, a default `=`; a choice is written `param kind : choice one | two`"
    elif 0 < len(clauses) <= 12:
        hint = f"expected {', '.join(f'`{clause}`' for clause in clauses)}"
    else:
        hint = "remove it, or begin a new line before it"
    return f"{stop.shown} cannot be part of this `{statement.value}`", hint


def _clauses(stop: _Stop) -> list[str]:
    """The words of the clauses that could follow in the statement."""
    words = terminal_words()
    leading = {"ON", "IN"} if stop.within("CONNECT", "JOINT") else set()
    refused = leading | {"TURNED"} if leading else set()  # `turned` is read there only to be refused
    follow = (stop.accepted - statement_words() - file_words() - OPERATORS - refused) | stop.accepted & leading
    return sorted(words[a] for a in follow if a in words and a not in ("AND", "OR"))

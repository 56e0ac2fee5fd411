"""What the parser would have taken at the token at which it stopped, if that is short; else what is plain from it."""

from __future__ import annotations

import re

from lark import Token, UnexpectedToken

from ...diagnostics.suggest import suggest
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


def by_accepts(error: UnexpectedToken, history: list[Token], span: Span) -> Found:
    """What the parser would have taken, if that is short; else what is plain from it."""
    token: Token = error.token
    accepted = (error.accepts or set()) - {"_NL"}
    words = terminal_words()
    shown = quoted(token)

    def found(message: str, hint: str | None = None) -> Found:
        return Found("syntax", span, message, span.start, hint)

    if accepted >= VALUE:
        return found(
            f"a value is missing before {shown}", "for example a number with its unit, a name or a vector `[x, y, z]`"
        )
    if accepted <= {"LBRACE"}:
        return found(f"`{{` is missing before {shown}", "what belongs to the statement stands in braces: `{ ... }`")
    statement = next((t for t in reversed(history) if t.type in statement_words() | file_words()), None)
    leading = {"ON", "IN"} if statement is not None and statement.type in ("CONNECT", "JOINT") else set()
    placing = leading | {"TURNED"} if leading else set()  # `turned` is read there only to be refused
    follow = (accepted - statement_words() - file_words() - OPERATORS - placing) | accepted & leading
    clauses = sorted(words[a] for a in follow if a in words and a not in ("AND", "OR"))
    if token.type == "COMMA" and re.match(r"\d,\d", span.source.text[span.start - 1 : span.start + 2]):
        return found("a number has a decimal point, not a comma", "write it as in `0.5`")
    if "UNTIL" in accepted and len(accepted) <= 4:
        return found(f"`..` is missing before {shown}", "a range is written `low .. high`")
    if (
        accepted == {"ARROW"}
        or accepted
        and "ARROW" in accepted
        and statement is not None
        and statement.type == "JOINT"
    ):
        return found(
            f"`->` is missing before {shown}",
            "`joint name : kind parent -> child`: the part that moves follows the arrow",
        )
    if "LBRACE" in accepted and token.type == "_NL":
        return found(f"`{{` is missing before {shown}", "what belongs to the statement stands in braces: `{ ... }`")
    if accepted == {"ELSE"}:
        within = open_bracket(history) is not None
        hint = _MEANT_BY_IF.get(statement.type) if statement is not None and not within else None
        return found(f"`else` is missing before {shown}", hint or "a value with a condition is written `a if c else b`")
    if token.type in ("RPAR", "RSQB") and token.type not in accepted:
        return found(f"{shown} has no matching opening bracket", "remove it, or add the missing bracket before it")
    if statement is not None and statement.type == "USE" and token.value == "as":
        return found("an import keeps its name", "leave `as` and the other name out")
    if 0 < len(accepted) <= 4:
        names = sorted(_SIGNS.get(a, f"`{words.get(a, a.lower())}`") for a in accepted)
        return found(
            f"expected {' or '.join(names)}, found {shown}",
            f"write {names[0]}" + ("" if token.type == "_NL" else " before it, or in its place"),
        )
    if statement is not None and token.type == "COMMA":
        message = "a comma separates values in brackets, names and targets"
        return found(message, "numbers use a decimal point, as in `0.5`; a statement ends at the end of its line")
    elsewhere = CLAUSES_ELSEWHERE.get((statement.value, token.value)) if statement is not None else None
    if statement is not None and elsewhere is not None:
        return found(f"`{statement.value}` takes no `{token.value}`", elsewhere)
    if statement is not None and token.value:
        near = suggest(token.value, clauses)
        if near is None and token.type == "NAME" and statement.type in ("LABEL", "MATERIAL", "FIELD"):
            example = "for example `label semantic.leg on left_leg, right_leg`"
            return found(f"a comma is missing before {shown}: targets are separated by commas", example)
        listed = ", ".join(f"`{c}`" for c in clauses)
        hint = (
            f"did you mean `{near}`?"
            if near
            else f"expected {listed}"
            if 0 < len(clauses) <= 12
            else "remove it, or begin a new line before it"
        )
        if near is None and statement.type == "PARAM" and [t.type for t in history[-2:]] == ["COLON", "NAME"]:
            hint = "a range follows `in`, a default `=`; a choice is written `param kind : choice one | two`"
        return found(f"{shown} cannot be part of this `{statement.value}`", hint)
    return found(f"{shown} is not allowed here", "remove it, or begin a new line before it")

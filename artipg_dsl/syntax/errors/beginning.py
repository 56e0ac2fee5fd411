"""What stands where a statement begins, and begins none, or none that may stand there."""

from __future__ import annotations

import re

from lark import Token

from ...diagnostics.suggest import suggest
from ...source import Span
from ..grammar import terminal_words
from ..recover import opening_brace
from ..words import OPERATORS, file_words, statement_words
from .foreign import STATEMENTS_ELSEWHERE
from .found import Found, Notes, quoted
from .stop import Stop
from .unclosed import brace_never_closed

_EQUATION = re.compile(r"((?:\.\w+|\[[^\]\n]*\])*) *=(?!=)")  # behind a name


def at_beginning(stop: Stop) -> Found | None:
    """The token stands where a statement begins."""
    token, top = stop.token, "CATEGORY" in stop.accepted
    last = stop.before[-1] if stop.before else None
    beginners = (file_words() if top else statement_words()) & stop.accepted
    end = token.end_pos or 0
    if not beginners:
        return None
    if token.type == "SLASH" and stop.text[end : end + 1] in ("/", "*"):
        return stop.found("a comment begins with `#`", "`##` documents the next declaration")
    if token.type in OPERATORS and last is not None and token.type != "IF":
        return stop.found(
            f"a line cannot begin with `{token.value}`: the statement above ended at the end of its line",
            "put the operator at the end of the line above, or put the whole expression in parentheses",
        )
    if token.value in STATEMENTS_ELSEWHERE:
        return stop.found(f"no statement begins with `{token.value}`", STATEMENTS_ELSEWHERE[token.value])
    if not re.fullmatch(r"[A-Za-z_]\w*", token.value):
        block = (
            "a block stands behind its statement, as in `when lid { ... }`; the one above has a block, or takes none"
        )
        word = "a statement begins with its keyword, such as `part`, `let` or `align`"
        return stop.found(f"no statement begins with {quoted(token)}", block if token.value == "{" else word)
    if token.type in (statement_words() if top else file_words()):
        return misplaced_at_top(stop, token, stop.before) if top else misplaced_within(stop, token)
    words = terminal_words()
    if token.type in words and last is not None and last.type == "_NL":
        return stop.found(
            f"no statement begins with `{token.value}`; the one above ended at the end of its line",
            f"move `{token.value} ...` up: a statement continues on the next line only in brackets or after `,`, `=` or an operator",
        )
    equation = _EQUATION.match(stop.text, end)
    if equation is not None and not top:
        verb = "align" if equation[1] else "let"
        return stop.found(
            f"no statement begins with `{token.value}`",
            f"write `{verb} {token.value}{equation[1]} = ...`: `align` states an equation, `let` names a value",
        )
    near = suggest(token.value, [words[b] for b in beginners if b in words])
    usual = "see docs/language.md" if top else "`let name = value` names a value, `align a = b` states an equation"
    return stop.found(f"no statement begins with `{token.value}`", f"did you mean `{near}`?" if near else usual)


def misplaced_within(stop: Stop, token: Token) -> Found:
    """A declaration of the file within a body."""
    brace = opening_brace(stop.text)
    if brace is not None:
        return brace_never_closed(brace, stop.source)
    return stop.found_at(token, f"`{token.value}` is not allowed inside a body", "move it to the top level of the file")


def misplaced_at_top(stop: Stop, token: Token, before: list[Token]) -> Found:
    """A statement at the top of a file, behind the tokens ``before``."""
    at = token.start_pos or 0
    span = Span(stop.source, at, token.end_pos or at)
    notes: Notes = ()
    last = next((t for t in reversed(before) if t.type != "_NL"), None)
    end = 0 if last is None else last.end_pos or 0
    told = stop.text[end:at] != stop.source.text[end:at]  # what opens its block has been blanked
    if last is not None and last.type == "RBRACE":
        notes = ((Span(stop.source, end - 1, end), "this brace ends the declaration above: is it one too many?"),)
    message = f"`{token.value}` is not allowed at the top level of a file"
    hint = "put it in a category, template, role or primitive"
    return Found("syntax", span, message, at, hint, notes, fatal=True, told=told)

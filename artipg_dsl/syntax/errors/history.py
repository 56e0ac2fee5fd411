"""What the tokens before the one at which the parser stopped tell."""

from __future__ import annotations

import re
from collections.abc import Callable

from lark import Token, UnexpectedToken

from ...diagnostics.suggest import suggest
from ...source import Source, Span
from ...units import UNITS
from ..grammar import Machine, terminal_words
from ..recover import opening_brace
from ..words import COMPARISONS, OPERATORS, VALUE, file_words, statement_words
from .foreign import CLAUSES_ELSEWHERE, STATEMENTS_ELSEWHERE
from .found import Found, Notes, quoted, span_of
from .unclosed import brace_never_closed, first_on_line, open_bracket

_Maker = Callable[..., Found]

_BEGINS_VALUE = frozenset("NUMBER QUANTITY FRACTION NAME STRING LPAR LSQB HOLE".split())
_ENDS_VALUE = frozenset("NUMBER QUANTITY FRACTION NAME STRING RPAR RSQB HOLE".split())
_CONDITIONS = frozenset("WHEN WHEN_BLOCK REQUIRE PREFER WHERE IF".split())


def by_history(error: UnexpectedToken, history: list[Token], tools: Machine, source: Source, text: str) -> Found | None:
    """What the tokens before tell."""
    token: Token = error.token
    last = history[-1] if history else None
    accepted = error.accepts or set()
    span = span_of(token, source, text)

    def found(message: str, hint: str | None = None, code: str = "syntax", notes: Notes = ()) -> Found:
        return Found(code, span, message, span.start, hint, notes)

    if token.type == "RBRACE" and accepted & file_words() and "RBRACE" not in accepted:
        return found("this brace has no matching `{`", "remove it, or add the missing `{` above")
    if token.type == "ON" and accepted == {"LBRACE"} and [t.type for t in history[-2:]] == ["MATERIAL", "NAME"]:
        # `material oak on` of a body, not the declaration `material oak {`
        return _misplaced(history[-2], history[:-2], True, source, text)
    if token.type == "LBRACE" and [t.type for t in history[-2:]] == ["MATERIAL", "NAME"] and accepted == {"ON"}:
        return _misplaced(history[-2], history[:-2], False, source, text)  # the declaration within a body
    if last is None or last.type in ("_NL", "LBRACE", "RBRACE"):
        beginning = _at_beginning(token, history, accepted, found, source, text)
        return beginning._replace(line_alone=True) if beginning is not None else None
    values = accepted >= VALUE
    if values and token.type in statement_words() | file_words() and first_on_line(token, source):
        at = last.start_pos or 0
        where = Span(source, at, last.end_pos or at)
        return Found(
            "syntax", where, f"a value is missing after `{last.value}`", at, "a statement ends at the end of its line"
        )
    reserved = token.value in tools.layout.reserved and last.type != "IS"
    if reserved and last.type == "USE":
        return found(f"`{token.value}` is a word of the language, not a module", f"did you mean `{token.value}s`?")
    if reserved and token.type == "NONE" and last.type in COMPARISONS:
        tells = "a part by itself tells whether it is there: `when handle { }`, `when not handle { }`"
        return found("`none` is no value: nothing equals it", tells)
    if reserved and accepted & {"NAME", "WORD"}:
        return found(
            f"`{token.value}` is a word of the language and cannot be used as a name",
            "choose another name",
            "reserved-word",
        )
    if values and token.type == "EQUAL" and last.type in terminal_words():
        return found(f"`{last.value}` is followed by its value alone", f"leave the `=` out: `{last.value} ...`")
    doubled = last.type == token.type == "SLASH" and last.end_pos == token.start_pos
    if doubled:
        return found("a comment begins with `#`", "for integer division, write `floor(a / b)`")
    statement = next(
        (t for t in reversed(history) if t.type in statement_words() | file_words() | {"WHERE", "IF"}), None
    )
    if token.type in ("COMMA", "ARROW") and statement is not None and statement.type == "JOINT":
        bracket = open_bracket(history)
        if bracket is not None and all(t.type != "ARROW" for t in history[history.index(statement) :]):
            message = "a joint names its parts without brackets"
            return found(message, "for example `joint open : revolute body -> door about door.left.back`")
    arrow = last.type == "MINUS" and token.type == "MORE" and last.end_pos == token.start_pos
    if arrow and statement is not None and statement.type == "JOINT":
        return found(
            "the kind of joint is missing", "for example `joint open : revolute body -> door about door.left.back`"
        )
    if last.type == "EQUAL" and token.type in ("MORE", "LESS") and last.end_pos == token.start_pos:
        return found(f"`={token.value}` is no comparison", f"write `{token.value}=`")
    if values and token.type == "DOT" and text[span.end : span.end + 1].isdigit():
        return found("a number must begin with a digit", "write `0.5`")
    if last.type in ("AND", "OR") and token.type in COMPARISONS:
        return found(
            f"a value is missing between `{last.value}` and {quoted(token)}",
            f"each comparison names both of its sides: `a > b {last.value} a {token.value} c`",
        )
    if last.type == "ON" and token.type == "STAR":
        return found(
            "`*` stands for nothing here", "name what is meant: `on body, door`; a part stands for all within it"
        )
    if (
        values
        and token.type in OPERATORS | {"_NL", "RPAR", "RSQB", "BAR", "RBRACE", "LBRACE"}
        and last.type in OPERATORS | {"EQUAL"}
    ):
        if (last.type, token.type) not in (("STAR", "STAR"), ("UNTIL", "DOT")):
            return found(
                f"a value is missing between `{last.value}` and {quoted(token)}",
                "write it, or remove one of the two signs",
            )
    if statement is not None and statement.type == "ALIGN" and token.type == "_NL":
        begin = statement.end_pos or 0
        compared = next((t for t in history if (t.start_pos or 0) >= begin and t.type in COMPARISONS), None)
        if compared is not None:
            return _compared(compared, source)
    if statement is not None and statement.type == last.type == "LIMIT" and not first_on_line(last, source):
        where = span_of(last, source, text)
        return Found("syntax", where, "`joint` takes no `limit`", where.start, CLAUSES_ELSEWHERE["joint", "limit"])
    if token.type == "EQUAL" and statement is not None and statement.type in _CONDITIONS:
        if (sign := text[span.end : span.end + 1]) in ("<", ">"):
            return found(f"`={sign}` is no comparison", f"write `{sign}=`")
        return found("`=` gives a name its value; it does not compare", "to compare, write `==`")
    if last.type in _ENDS_VALUE and token.type in _BEGINS_VALUE:
        return _two_values(token, last, history, found)
    return None


def _compared(sign: Token, source: Source) -> Found:
    """An ``align`` that compares."""
    where = span_of(sign, source, source.text)
    said = source.line(where.line).partition("align ")[2].split("#")[0].strip()
    hint = f"to require a comparison, write `require {said}`"
    return Found("syntax", where, "`align` states an equation with a single `=`", where.start, hint)


def _at_beginning(
    token: Token, before: list[Token], accepted: set[str], found: _Maker, source: Source, text: str
) -> Found | None:
    """The token stands where a statement begins, behind the tokens ``before``."""
    last = before[-1] if before else None
    top = "CATEGORY" in accepted
    beginners = (file_words() if top else statement_words()) & accepted
    if not beginners:
        return None
    if token.type == "SLASH" and text[(token.end_pos or 0) : (token.end_pos or 0) + 1] in ("/", "*"):
        return found("a comment begins with `#`", "`##` documents the next declaration")
    if token.type in OPERATORS and last is not None and token.type != "IF":
        return found(
            f"a line cannot begin with `{token.value}`: the statement above ended at the end of its line",
            "put the operator at the end of the line above, or put the whole expression in parentheses",
        )
    if token.value in STATEMENTS_ELSEWHERE:
        return found(f"no statement begins with `{token.value}`", STATEMENTS_ELSEWHERE[token.value])
    if not re.fullmatch(r"[A-Za-z_]\w*", token.value):
        block = (
            "a block stands behind its statement, as in `when lid { ... }`; the one above has a block, or takes none"
        )
        word = "a statement begins with its keyword, such as `part`, `let` or `align`"
        return found(f"no statement begins with {quoted(token)}", block if token.value == "{" else word)
    if top and token.type in statement_words() or not top and token.type in file_words():
        return _misplaced(token, before, top, source, text)
    words = terminal_words()
    if token.type in words and last is not None and last.type == "_NL":
        return found(
            f"no statement begins with `{token.value}`; the one above ended at the end of its line",
            f"move `{token.value} ...` up: a statement continues on the next line only in brackets or after `,`, `=` or an operator",
        )
    equation = re.match(r"((?:\.\w+|\[[^\]\n]*\])*) *=(?!=)", text[token.end_pos or 0 :])
    if equation is not None and not top:
        verb = "align" if equation[1] else "let"
        return found(
            f"no statement begins with `{token.value}`",
            f"write `{verb} {token.value}{equation[1]} = ...`: `align` states an equation, `let` names a value",
        )
    near = suggest(token.value, [words[b] for b in beginners if b in words])
    hint = f"did you mean `{near}`?" if near else None
    if hint is None:
        hint = (
            "`let name = value` names a value, `align a = b` states an equation" if not top else "see docs/language.md"
        )
    return found(f"no statement begins with `{token.value}`", hint)


def _misplaced(token: Token, before: list[Token], top: bool, source: Source, text: str) -> Found:
    """A statement at the top of a file, or a declaration of the file within a body, behind the tokens ``before``."""
    at = token.start_pos or 0
    span = Span(source, at, token.end_pos or at)
    brace = opening_brace(text)
    if not top and brace is not None:
        return brace_never_closed(brace, source)
    if not top:
        return Found(
            "syntax", span, f"`{token.value}` is not allowed inside a body", at, "move it to the top level of the file"
        )
    notes: Notes = ()
    last = next((t for t in reversed(before) if t.type != "_NL"), None)
    end = 0 if last is None else last.end_pos or 0
    told = text[end:at] != source.text[end:at]  # what opens its block has been blanked
    if last is not None and last.type == "RBRACE":
        notes = ((Span(source, end - 1, end), "this brace ends the declaration above: is it one too many?"),)
    message = f"`{token.value}` is not allowed at the top level of a file"
    hint = "put it in a category, template, role or primitive"
    return Found("syntax", span, message, at, hint, notes, fatal=True, told=told)


def _two_values(token: Token, last: Token, history: list[Token], found: _Maker) -> Found | None:
    """Two values in a row."""
    if last.type == "NUMBER" and last.value[-1].isdigit() and token.value in UNITS:
        return found("a unit must directly follow its number", f"write `{last.value}{token.value}`")
    if open_bracket(history) is not None:
        return found(
            f"a comma or an operator is missing before `{token.value}`", "values in brackets are separated by commas"
        )
    words = [t for t in history if t.type in statement_words() or t.type in ("IN", "RANGE", "EACH", "TEST")]
    if words and words[-1].type in ("IN", "RANGE", "EACH", "TEST") and token.type in ("NUMBER", "QUANTITY", "FRACTION"):
        return found("`..` is missing between the ends of this range", "a range is written `low .. high`")
    if words and words[-1].type == "JOINT" and history[-1] is last and history[-2:-1] == [words[-1]]:
        return found("`:` is missing between the name and its kind", "`joint name : kind parent -> child`")
    if words and words[-1].type == "JOINT" and "ARROW" not in {t.type for t in history[history.index(words[-1]) :]}:
        return found(f"`->` is missing before `{token.value}`", "`joint name : kind parent -> child`")
    if (
        words
        and words[-1].type == "CONNECT"
        and not {t.type for t in history[history.index(words[-1]) :]} & {"TO", "ON", "IN", "BETWEEN"}
    ):
        return found(
            f"`on` or `to` is missing before `{token.value}`",
            "`connect lid.bottom on body.top` for faces, `to` for ports",
        )
    if words and words[-1].type == "ALIGN" and "EQUAL" not in {t.type for t in history[history.index(words[-1]) :]}:
        return found(f"`=` is missing before `{token.value}`", "an equation is written `align a.left = b.right + 1mm`")
    return None

"""Syntax errors in words: what stands there, what was expected, what to try.

First what the lexer cannot read, then what is never closed, then what the tokens before tell, then the table of
mistakes by example, and last what the parser would have taken.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple, cast

from lark import Token, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from ..diagnostics.suggest import suggest
from ..source import Source, Span
from ..units import UNITS
from . import dangling
from .examples import key, table
from .foreign import CHARACTERS, CLAUSES_ELSEWHERE, MICROMETRES, STATEMENTS_ELSEWHERE
from .grammar import Machine, terminal_words
from .recover import opening_brace
from .words import COMPARISONS, OPERATORS, file_words, statement_words

Notes = tuple[tuple[Span, str], ...]
Maker = Callable[..., "Found"]

_VALUE = frozenset({"NUMBER", "NAME", "LPAR"})
_BEGINS_VALUE = frozenset("NUMBER QUANTITY FRACTION NAME STRING LPAR LSQB HOLE".split())
_ENDS_VALUE = frozenset("NUMBER QUANTITY FRACTION NAME STRING RPAR RSQB HOLE".split())
_CONDITIONS = frozenset("WHEN WHEN_BLOCK REQUIRE PREFER WHERE IF".split())
_ALSO_VALUES = frozenset("OUT BOX INSIDE CLOSE FREE CLEAR FIELD LIMIT".split())  # words that may stand in brackets
_OF_TARGETS = re.compile(r"\s*(label|material|field|connect|joint)\b(?!.*\b(?:where|when)\b)")
_PAIRS = {"LPAR": "(", "LSQB": "["}
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


class Found(NamedTuple):
    """A syntax error: what to say, and the offset where parsing stopped."""

    code: str
    span: Span
    message: str
    place: int
    hint: str | None = None
    notes: Notes = ()
    fatal: bool = False  # what follows would only be consequences
    line_alone: bool = False  # the statement before is complete
    told: bool = False  # it follows from an error before it


def describe(error: UnexpectedInput, tools: Machine, source: Source, text: str) -> Found:
    """What is wrong at the place where the parser stopped."""
    history = cast("list[Token]", list(tools.layout.seen))  # it has seen those of lark
    if isinstance(error, UnexpectedCharacters):
        return _character(error.pos_in_stream or 0, source, text)
    assert isinstance(error, UnexpectedToken)
    token: Token = error.token
    if token.type != "$END" and history and history[-1].start_pos == token.start_pos:
        history.pop()
    if token.type == "$END":
        found = _end(error, history, source, text)
    elif (bar := dangling.find_bar([*history, token], text, statement_words() | file_words())) is not None:
        at = bar.start_pos or 0
        return Found("syntax", Span(source, at, at + 1), dangling.MESSAGE, at, dangling.HINT)
    else:
        found = _unclosed(token, history, source) or _by_history(error, history, tools, source, text)
    if found is not None:
        return found
    span = _span(token, source, text)
    mistake = table(tools).get(key(error))
    if mistake is not None:
        return Found("syntax", span, mistake.message.replace("`{}`", _quoted(token)), span.start, mistake.hint)
    return _by_accepts(error, history, tools, span)


def _span(token: Token, source: Source, text: str) -> Span:
    if token.type == "$END":
        end = len(text.rstrip())
        return Span(source, max(0, end - 1), end)
    return Span(source, token.start_pos or 0, token.end_pos or 0)


def _shown(token: Token) -> str:
    if token.type == "_NL":
        return "the end of the line"
    return "the end of the file" if token.type == "$END" else token.value


def _quoted(token: Token) -> str:
    shown = _shown(token)
    return shown if token.type in ("_NL", "$END") else f"`{shown}`"


def _character(at: int, source: Source, text: str) -> Found:
    char = text[at]
    span = Span(source, at, at + 1)
    if char == '"':
        line_end = text.find("\n", at)
        whole = Span(source, at, len(text) if line_end < 0 else line_end)
        return Found("unterminated-string", whole, "this text has no closing quote on its line", at, 'end it with `"`')
    if char.isalpha():
        start = at
        while start and (text[start - 1].isalnum() or text[start - 1] == "_"):
            start -= 1
        word = re.compile(r"\w+").match(text, start)
        assert word is not None
        span = Span(source, start, word.end())
        if char in CHARACTERS:
            return Found("syntax", Span(source, at, at + 1), f"`{char}` has no meaning here", at, CHARACTERS[char])
        if unit := word.group().lstrip("0123456789") if word.group()[0].isdigit() else "":
            told = "write it in mm: a micrometre is `0.001mm`" if unit in MICROMETRES else "use mm, cm, m, deg, kg or s"
            return Found("syntax", span, f"there is no unit `{unit}`", start, told)
        return Found(
            "syntax",
            span,
            f"`{word.group()}` is not a valid name",
            start,
            "a name consists of the letters a to z, digits and `_`",
        )
    if char == "&" and (statement := _OF_TARGETS.match(source.line(span.line))):
        said = "targets are separated by commas, as in `on body, lid`"
        once = "a part is attached once, to one place; a `connect` attaches one part"
        hint = said if statement[1] in ("label", "material", "field") else once
        return Found("syntax", span, f"`{char}` has no meaning here", at, hint)
    shown = f"`{char}`" if char.isprintable() else f"the character U+{ord(char):04X}"
    return Found("syntax", span, f"{shown} has no meaning here", at, CHARACTERS.get(char))


def _open_bracket(history: list[Token]) -> Token | None:
    """The innermost round or square bracket that is open behind these tokens."""
    stack: list[Token] = []
    for token in history:
        if token.type in _PAIRS:
            stack.append(token)
        elif token.type in ("RPAR", "RSQB") and stack:
            stack.pop()
        elif token.type in ("LBRACE", "RBRACE"):
            stack.clear()
    return stack[-1] if stack else None


def _end(error: UnexpectedToken, history: list[Token], source: Source, text: str) -> Found | None:
    bracket = _open_bracket(history)
    if bracket is not None:
        return _never_closed(bracket, source)
    at = opening_brace(text)
    if at is None:
        return None
    accepted = error.accepts or set()
    if "RBRACE" not in accepted and not _may_end(history, accepted):
        return None
    return _brace(at, source)


def _may_end(history: list[Token], accepted: set[str]) -> bool:
    return not history or history[-1].type in ("_NL", "LBRACE", "RBRACE") or "_NL" in accepted


def _never_closed(bracket: Token, source: Source) -> Found:
    start = bracket.start_pos or 0
    closing = {"(": ")", "[": "]"}[bracket.value]
    return Found(
        "missing-bracket",
        Span(source, start, start + 1),
        "this bracket is never closed",
        start,
        f"add the missing `{closing}`",
    )


def _unclosed(token: Token, history: list[Token], source: Source) -> Found | None:
    """A statement begins, or a block ends, within brackets."""
    bracket = _open_bracket(history)
    begins = token.type in (statement_words() | file_words()) - _ALSO_VALUES
    if bracket is not None and token.type == "LBRACE" and history[-1].type in ("EQUAL", "COMMA", "LPAR", "LSQB"):
        start = token.start_pos or 0
        return Found(
            "syntax",
            Span(source, start, start + 1),
            "a vector is written in square brackets",
            start,
            "write `[x, y, z]`",
        )
    if bracket is not None and (begins and _first_on_line(token, source) or token.type in ("LBRACE", "RBRACE")):
        return _never_closed(bracket, source)
    if bracket is not None and token.type in ("RPAR", "RSQB") and (bracket.type == "LPAR") != (token.type == "RPAR"):
        return _never_closed(bracket, source)
    return None


def _first_on_line(token: Token, source: Source) -> bool:
    start = token.start_pos or 0
    return not source.text[source.text.rfind("\n", 0, start) + 1 : start].strip()


def _by_history(
    error: UnexpectedToken, history: list[Token], tools: Machine, source: Source, text: str
) -> Found | None:
    """What the tokens before tell."""
    token: Token = error.token
    last = history[-1] if history else None
    accepted = error.accepts or set()
    span = _span(token, source, text)

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
        beginning = _at_beginning(token, history, accepted, tools, found, source, text)
        return beginning._replace(line_alone=True) if beginning is not None else None
    values = accepted >= _VALUE
    if values and token.type in statement_words() | file_words() and _first_on_line(token, source):
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
        bracket = _open_bracket(history)
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
            f"a value is missing between `{last.value}` and {_quoted(token)}",
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
                f"a value is missing between `{last.value}` and {_quoted(token)}",
                "write it, or remove one of the two signs",
            )
    if statement is not None and statement.type == "ALIGN" and token.type == "_NL":
        begin = statement.end_pos or 0
        compared = next((t for t in history if (t.start_pos or 0) >= begin and t.type in COMPARISONS), None)
        if compared is not None:
            return _compared(compared, source)
    if statement is not None and statement.type == last.type == "LIMIT" and not _first_on_line(last, source):
        where = _span(last, source, text)
        return Found("syntax", where, "`joint` takes no `limit`", where.start, CLAUSES_ELSEWHERE["joint", "limit"])
    if token.type == "EQUAL" and statement is not None and statement.type in _CONDITIONS:
        if (sign := text[span.end : span.end + 1]) in ("<", ">"):
            return found(f"`={sign}` is no comparison", f"write `{sign}=`")
        return found("`=` gives a name its value; it does not compare", "to compare, write `==`")
    if last.type in _ENDS_VALUE and token.type in _BEGINS_VALUE:
        return _two_values(token, last, history, accepted, found)
    return None


def _compared(sign: Token, source: Source) -> Found:
    """An ``align`` that compares."""
    where = _span(sign, source, source.text)
    said = source.line(where.line).partition("align ")[2].split("#")[0].strip()
    hint = f"to require a comparison, write `require {said}`"
    return Found("syntax", where, "`align` states an equation with a single `=`", where.start, hint)


def _at_beginning(
    token: Token, before: list[Token], accepted: set[str], tools: Machine, found: Maker, source: Source, text: str
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
        return found(f"no statement begins with {_quoted(token)}", block if token.value == "{" else word)
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
        return _brace(brace, source)
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


def _brace(at: int, source: Source) -> Found:
    return Found(
        "missing-brace", Span(source, at, at + 1), "this brace is never closed", at, "add the missing `}`", fatal=True
    )


def _two_values(token: Token, last: Token, history: list[Token], accepted: set[str], found: Maker) -> Found | None:
    """Two values in a row."""
    if last.type == "NUMBER" and last.value[-1].isdigit() and token.value in UNITS:
        return found("a unit must directly follow its number", f"write `{last.value}{token.value}`")
    if _open_bracket(history) is not None:
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


def _by_accepts(error: UnexpectedToken, history: list[Token], tools: Machine, span: Span) -> Found:
    """What the parser would have taken, if that is short; else what is plain from it."""
    token: Token = error.token
    accepted = (error.accepts or set()) - {"_NL"}
    words = terminal_words()
    shown = _quoted(token)

    def found(message: str, hint: str | None = None) -> Found:
        return Found("syntax", span, message, span.start, hint)

    if accepted >= _VALUE:
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
        within = _open_bracket(history) is not None
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

"""What the tokens before the one at which the parser stopped tell: a rule each, the first that knows counts."""

from __future__ import annotations

from collections.abc import Callable

from lark import Token

from ...units import UNITS
from ..grammar import terminal_words
from ..words import COMPARISONS, OPERATORS, file_words, statement_words
from .beginning import at_beginning, misplaced_at_top, misplaced_within
from .foreign import CLAUSES_ELSEWHERE
from .found import Found, quoted
from .stop import Stop
from .unclosed import first_on_line, open_bracket

_BEGINS_VALUE = frozenset("NUMBER QUANTITY FRACTION NAME STRING LPAR LSQB HOLE".split())
_ENDS_VALUE = frozenset("NUMBER QUANTITY FRACTION NAME STRING RPAR RSQB HOLE".split())
_CONDITIONS = "WHEN", "WHEN_BLOCK", "REQUIRE", "PREFER", "WHERE", "IF"
_ENDS = frozenset({"_NL", "RPAR", "RSQB", "BAR", "RBRACE", "LBRACE"})
_JOINT = "for example `joint open : revolute body -> door about door.left.back`"
_PARTS = "`joint name : kind parent -> child`"


def by_history(stop: Stop) -> Found | None:
    """What the tokens before tell."""
    token, accepted = stop.token, stop.accepted
    if token.type == "RBRACE" and accepted & file_words() and "RBRACE" not in accepted:
        return stop.found("this brace has no matching `{`", "remove it, or add the missing `{` above")
    if stop.follows("MATERIAL", "NAME"):
        *before, material, _ = stop.before
        if token.type == "ON" and accepted == {"LBRACE"}:  # `material oak on` of a body, not a declaration
            return misplaced_at_top(stop, material, before)
        if token.type == "LBRACE" and accepted == {"ON"}:  # the declaration `material oak {` within a body
            return misplaced_within(stop, material)
    last = stop.before[-1] if stop.before else None
    if last is None or last.type in ("_NL", "LBRACE", "RBRACE"):
        beginning = at_beginning(stop)
        return beginning._replace(line_alone=True) if beginning is not None else None
    return next((found for rule in _RULES if (found := rule(stop, last)) is not None), None)


def _ends_too_early(stop: Stop, last: Token) -> Found | None:
    """The next statement begins where a value is missing."""
    begins = stop.token.type in statement_words() | file_words() and first_on_line(stop.token, stop.source)
    if not stop.values or not begins:
        return None
    return stop.found_at(last, f"a value is missing after `{last.value}`", "a statement ends at the end of its line")


def _reserved(stop: Stop, last: Token) -> Found | None:
    """A word of the language where a name stands."""
    word = stop.token.value
    if word not in stop.tools.layout.reserved or last.type == "IS":
        return None
    if last.type == "USE":
        return stop.found(f"`{word}` is a word of the language, not a module", f"did you mean `{word}s`?")
    if stop.token.type == "NONE" and last.type in COMPARISONS:
        tells = "a part by itself tells whether it is there: `when handle { }`, `when not handle { }`"
        return stop.found("`none` is no value: nothing equals it", tells)
    if stop.accepted & {"NAME", "WORD"}:
        message = f"`{word}` is a word of the language and cannot be used as a name"
        return stop.found(message, "choose another name", "reserved-word")
    return None


def _value_alone(stop: Stop, last: Token) -> Found | None:
    """An equals sign behind a clause."""
    if not stop.values or stop.token.type != "EQUAL" or last.type not in terminal_words():
        return None
    return stop.found(f"`{last.value}` is followed by its value alone", f"leave the `=` out: `{last.value} ...`")


def _two_slashes(stop: Stop, last: Token) -> Found | None:
    if not (last.type == stop.token.type == "SLASH" and stop.touches(last)):
        return None
    return stop.found("a comment begins with `#`", "for integer division, write `floor(a / b)`")


def _joint(stop: Stop, last: Token) -> Found | None:
    """A joint with brackets around its parts, or without a kind."""
    if stop.opener is None or not stop.within("JOINT"):
        return None
    bracketed = stop.token.type in ("COMMA", "ARROW") and open_bracket(stop.before) is not None
    if bracketed and "ARROW" not in stop.since(stop.opener):
        return stop.found("a joint names its parts without brackets", _JOINT)
    if last.type == "MINUS" and stop.token.type == "MORE" and stop.touches(last):  # `->` where a value may stand
        return stop.found("the kind of joint is missing", _JOINT)
    return None


def _turned_comparison(stop: Stop, last: Token) -> Found | None:
    """``=<`` and ``=>``."""
    if not (last.type == "EQUAL" and stop.token.type in ("MORE", "LESS") and stop.touches(last)):
        return None
    return stop.found(f"`={stop.token.value}` is no comparison", f"write `{stop.token.value}=`")


def _bare_fraction(stop: Stop, last: Token) -> Found | None:
    """``.5``."""
    end = stop.span.end
    if not stop.values or stop.token.type != "DOT" or not stop.text[end : end + 1].isdigit():
        return None
    return stop.found("a number must begin with a digit", "write `0.5`")


def _half_comparison(stop: Stop, last: Token) -> Found | None:
    """``a > b and < c``."""
    if last.type not in ("AND", "OR") or stop.token.type not in COMPARISONS:
        return None
    return stop.found(
        f"a value is missing between `{last.value}` and {quoted(stop.token)}",
        f"each comparison names both of its sides: `a > b {last.value} a {stop.token.value} c`",
    )


def _star(stop: Stop, last: Token) -> Found | None:
    """``on *``."""
    if last.type != "ON" or stop.token.type != "STAR":
        return None
    hint = "name what is meant: `on body, door`; a part stands for all within it"
    return stop.found("`*` stands for nothing here", hint)


def _missing_operand(stop: Stop, last: Token) -> Found | None:
    """Two signs in a row."""
    signs = stop.token.type in OPERATORS | _ENDS and last.type in OPERATORS | {"EQUAL"}
    known_as_mistakes = (last.type, stop.token.type) in (("STAR", "STAR"), ("UNTIL", "DOT"))
    if not stop.values or not signs or known_as_mistakes:
        return None
    message = f"a value is missing between `{last.value}` and {quoted(stop.token)}"
    return stop.found(message, "write it, or remove one of the two signs")


def _compared(stop: Stop, last: Token) -> Found | None:
    """An ``align`` that compares."""
    if stop.opener is None or not stop.within("ALIGN") or stop.token.type != "_NL":
        return None
    begin = stop.opener.end_pos or 0
    sign = next((t for t in stop.before if (t.start_pos or 0) >= begin and t.type in COMPARISONS), None)
    if sign is None:
        return None
    line = stop.source.line(stop.source.position(sign.start_pos or 0)[0])
    said = line.partition("align ")[2].split("#")[0].strip()
    hint = f"to require a comparison, write `require {said}`"
    return stop.found_at(sign, "`align` states an equation with a single `=`", hint)


def _limited(stop: Stop, last: Token) -> Found | None:
    """A ``limit`` as a clause of a joint."""
    if not stop.within("LIMIT") or last.type != "LIMIT" or first_on_line(last, stop.source):
        return None
    return stop.found_at(last, "`joint` takes no `limit`", CLAUSES_ELSEWHERE["joint", "limit"])


def _assigned(stop: Stop, last: Token) -> Found | None:
    """A single equals sign in a condition."""
    if stop.token.type != "EQUAL" or not stop.within(*_CONDITIONS):
        return None
    end = stop.span.end
    if (sign := stop.text[end : end + 1]) in ("<", ">"):
        return stop.found(f"`={sign}` is no comparison", f"write `{sign}=`")
    return stop.found("`=` gives a name its value; it does not compare", "to compare, write `==`")


def _two_values(stop: Stop, last: Token) -> Found | None:
    """Two values in a row."""
    token = stop.token
    if last.type not in _ENDS_VALUE or token.type not in _BEGINS_VALUE:
        return None
    if last.type == "NUMBER" and last.value[-1].isdigit() and token.value in UNITS:
        return stop.found("a unit must directly follow its number", f"write `{last.value}{token.value}`")
    if open_bracket(stop.before) is not None:
        hint = "values in brackets are separated by commas"
        return stop.found(f"a comma or an operator is missing before `{token.value}`", hint)
    ranges = "IN", "RANGE", "EACH", "TEST"
    word = next((t for t in reversed(stop.before) if t.type in statement_words() or t.type in ranges), None)
    if word is None:
        return None
    since = stop.since(word)
    if word.type in ranges and token.type in ("NUMBER", "QUANTITY", "FRACTION"):
        return stop.found("`..` is missing between the ends of this range", "a range is written `low .. high`")
    if word.type == "JOINT" and stop.before[-2:-1] == [word]:
        return stop.found("`:` is missing between the name and its kind", _PARTS)
    if word.type == "JOINT" and "ARROW" not in since:
        return stop.found(f"`->` is missing before `{token.value}`", _PARTS)
    if word.type == "CONNECT" and not since & {"TO", "ON", "IN", "BETWEEN"}:
        hint = "`connect lid.bottom on body.top` for faces, `to` for ports"
        return stop.found(f"`on` or `to` is missing before `{token.value}`", hint)
    if word.type == "ALIGN" and "EQUAL" not in since:
        hint = "an equation is written `align a.left = b.right + 1mm`"
        return stop.found(f"`=` is missing before `{token.value}`", hint)
    return None


_RULES: tuple[Callable[[Stop, Token], Found | None], ...] = (
    _ends_too_early,
    _reserved,
    _value_alone,
    _two_slashes,
    _joint,
    _turned_comparison,
    _bare_fraction,
    _half_comparison,
    _star,
    _missing_operand,
    _compared,
    _limited,
    _assigned,
    _two_values,
)

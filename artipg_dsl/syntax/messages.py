"""Syntax errors in words: what stands there, what was expected, what to try."""

from __future__ import annotations

import re

from lark import Token, UnexpectedCharacters, UnexpectedEOF, UnexpectedInput, UnexpectedToken

from ..diagnostics import Report
from ..source import Source, Span

STATEMENTS = frozenset(
    "PARAM INHERIT OUT COUNT LET CURVE ROOT PART STYLE SLOT PORT JOINT CONNECT ALIGN REQUIRE PREFER CLEAR ALLOW FREE LIMIT "
    "CLOSE REPEAT WHEN LABEL FIELD GRASP KEYPOINT SYMMETRY MATERIAL SURFACE INSIDE BOX PIECE SOLID".split()
)
EXPRESSION = frozenset({"NUMBER", "NAME", "LSQB", "LPAR", "STRING"})
SHOWN = {
    "LBRACE": "`{`", "RBRACE": "`}`", "LPAR": "`(`", "RPAR": "`)`", "LSQB": "`[`", "RSQB": "`]`", "COLON": "`:`", "COMMA": "`,`",
    "EQ": "`=`", "DOT": "`.`", "NAME": "a name", "NUMBER": "a number", "STRING": "a text in quotes", "__ANON_0": "`..`",
}  # fmt: skip
RESERVED = frozenset(
    "param inherit count let part style slot port joint connect align require prefer repeat when label grasp keypoint symmetry "
    "role template primitive category vocabulary use in for is else on none and or not if".split()
)


def report_error(error: UnexpectedInput, source: Source, report: Report) -> None:
    """Put a syntax error into the report."""
    if isinstance(error, UnexpectedCharacters):
        characters(error, source, report)
    elif isinstance(error, UnexpectedToken):
        unexpected(error, source, report)
    elif isinstance(error, UnexpectedEOF):
        end = Span(source, len(source.text), len(source.text))
        report.error("syntax", end, "the text ends too early")


def characters(error: UnexpectedCharacters, source: Source, report: Report) -> None:
    start = error.pos_in_stream
    span = Span(source, start, start + 1)
    char = source.text[start]
    allowed = {str(a) for a in (error.allowed or ())}
    if char == '"':
        report.error("unterminated-string", span, "this text has no closing quote on its line", hint='end it with `"`')
        return
    word = re.match(r"[A-Za-z_][A-Za-z0-9_]*", source.text[start:])
    if word is not None:
        word_span = Span(source, start, start + word.end())
        if word.group() in RESERVED and "NAME" in allowed:
            report.error("reserved-word", word_span, f"`{word.group()}` is a word of the language and cannot be a name here")
            return
        place_error(word_span, f"`{word.group()}`", allowed, source, report)
        return
    place_error(span, f"`{char}`", allowed, source, report)


def unexpected(error: UnexpectedToken, source: Source, report: Report) -> None:
    token: Token = error.token
    accepted = {str(a) for a in (error.accepts or error.expected)}
    if token.type == "$END":
        opening = open_brace(source.text)
        if opening is not None and "RBRACE" in accepted:
            span = Span(source, opening, opening + 1)
            report.error("missing-brace", span, "this brace is never closed", hint="add the missing `}`")
            return
        end = Span(source, len(source.text.rstrip()), len(source.text.rstrip()))
        place_error(end, "the end of the text", accepted, source, report)
        return
    span = Span(source, token.start_pos or 0, token.end_pos or 0)
    if str(token) in RESERVED and "NAME" in accepted and not accepted & STATEMENTS:
        report.error("reserved-word", span, f"`{token}` is a word of the language and cannot be a name here")
        return
    place_error(span, f"`{token}`", accepted, source, report)


def place_error(span: Span, found: str, accepted: set[str], source: Source, report: Report) -> None:
    message, hint = describe(found, accepted, span, source)
    report.error("syntax", span, message, hint=hint)


def describe(found: str, accepted: set[str], span: Span, source: Source) -> tuple[str, str | None]:
    """A message and a hint from what the parser would have accepted."""
    before = source.text[: span.start].rstrip()
    same_line = source.line(span.line)
    statement = (re.match(r"\s*([a-z]+)", same_line) or [None, ""])[1]
    operator = found.strip("`")
    if operator in {"<", ">", "<=", ">=", "=="} and re.search(r"[<>]=?", same_line[: span.column - 1]):
        return f"{found} compares a second time", "compare twice: `a < b and b < c`"
    if accepted & EXPRESSION and not accepted & STATEMENTS:
        return f"a value is missing before {found}", "write a number with its unit, a name, or a vector [x, y, z]"
    if "COLON" in accepted and statement in ("param", "part", "style", "joint", "inherit", "out") and "EQ" not in accepted:
        examples = {
            "param": "param width : length in 40cm .. 60cm = 50cm", "inherit": "inherit size : length[3]",
            "part": "part door : Door = SlabDoor | WindowDoor", "style": "style pull : Handle = BarHandle | none",
            "joint": "joint open : revolute body -> door about door.left.back range 0deg .. 90deg", "out": "out mouth : length",
        }  # fmt: skip
        return f"`:` is missing before {found}", f"for example: {examples[statement]}"
    if before.endswith("}") and found == "`}`":
        return "this brace closes nothing", "remove it, or look for a missing `{`"
    if accepted & STATEMENTS and "RBRACE" in accepted:
        return f"{found} does not continue this statement, and no statement begins with it", "see docs/language.md for the statements"
    names = sorted(SHOWN[a] for a in accepted if a in SHOWN)
    words = sorted(f"`{a.lower()}`" for a in accepted if a not in SHOWN and a.isupper() and not a.startswith("__") and a not in STATEMENTS)
    listed = names + words
    if 0 < len(listed) <= 5:
        return f"{found} stands where {' or '.join(listed)} was expected", None
    return f"{found} cannot stand here", None


def open_brace(text: str) -> int | None:
    """The innermost brace that is never closed, comments and texts left out."""
    plain = re.sub(r'"(?:[^"\\\n]|\\.)*"|#[^\n]*', lambda m: " " * len(m.group()), text)
    stack: list[int] = []
    for match in re.finditer(r"[{}]", plain):
        if match.group() == "{":
            stack.append(match.start())
        elif stack:
            stack.pop()
    return stack[-1] if stack else None

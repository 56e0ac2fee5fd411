"""One layout for the text of programs: indentation, blank lines and the spaces that are never a matter of taste.

What an author has aligned by hand stays aligned: more than one space between two words is left alone, and so are line ends within a
statement. The tokens and comments of the result are those of the text, which is checked.
"""

from __future__ import annotations

from ..diagnostics import Report
from ..records import dataclass
from ..source import Source
from .grammar import machine
from .parse import parse
from .token import Token

STEP = 2
APART = frozenset(
    "EQUAL ARROW UPTO UNTIL BAR TILDE EQUALS UNEQUAL LESS AT_MOST MORE AT_LEAST LBRACE RBRACE COLON".split()
)
"""Tokens with a space on both sides."""
_COMMENTS = frozenset(("COMMENT", "DOC"))
_CLOSING = frozenset(("RPAR", "RSQB", "RBRACE"))


class _ChangedMeaning(AssertionError):
    """The layout would have changed the program: a fault of this module, and nothing is written."""


@dataclass(slots=True)
class _Piece:
    """A token or comment, the text between the one before and it, and whether a statement ended there."""

    token: Token
    gap: str
    ended: bool

    @property
    def breaks(self) -> int:
        return self.gap.count("\n")


def format_source(source: Source, report: Report) -> str | None:
    """The text of ``source`` laid out; None after reporting why it does not parse."""
    if parse(source, report) is None:
        return None
    pieces = _pieces(source.text)
    text = "".join(_lines(pieces))
    check = Report()
    if parse(Source(source.name, text), check) is None or _content(_pieces(text)) != _content(pieces):
        raise _ChangedMeaning(f"formatting {source.name} would change its tokens or comments")
    return text


def _pieces(text: str) -> list[_Piece]:
    """Tokens and comments of the text parsed last, in their order."""
    layout = machine().layout
    tokens = sorted((*layout.seen, *layout.comments), key=lambda t: t.start_pos)
    found: list[_Piece] = []
    end, ended = 0, False
    for token in tokens:
        start = token.start_pos
        if token.type == "_NL":
            ended = True
        elif token.type != "$END":
            found.append(_Piece(token, text[end:start], ended))
            end, ended = token.end_pos, False
    return found


def _content(pieces: list[_Piece]) -> list[tuple[str, str]]:
    return [(p.token.type, p.token.value.rstrip()) for p in pieces]


def _lines(pieces: list[_Piece]) -> list[str]:
    """The pieces with what goes between them."""
    out: list[str] = []
    open_: list[bool] = []  # of each brace around: whether its line ends behind it
    shift = 0  # by how much the statement at hand has moved to the right
    for at, piece in enumerate(pieces):
        token, before = piece.token, pieces[at - 1].token if at else None
        within = bool(open_) and not open_[-1]
        if token.type == "RBRACE":
            open_.pop()
        if before is not None and piece.breaks:
            blank = piece.breaks > 1 and before.type != "LBRACE" and token.type != "RBRACE"
            wanted, old = STEP * len(open_), len(piece.gap.rpartition("\n")[2].expandtabs(STEP))
            if within or _continued(pieces, at):
                wanted = max(old + shift, wanted + STEP * (token.type not in _CLOSING))
            elif token.type not in _COMMENTS:
                shift = wanted - old
            out.append("\n" * (1 + blank) + " " * wanted)
        elif before is not None:
            out.append(_space(before, token, piece.gap))
        out.append(token.value.rstrip())
        if token.type == "LBRACE":
            behind = next((p for p in pieces[at + 1 :] if p.breaks or p.token.type not in _COMMENTS), piece)
            open_.append(behind.breaks > 0)
    return [*out, "\n"]


def _continued(pieces: list[_Piece], at: int) -> bool:
    """Whether a line goes on with the statement of the line before; a comment does what the token behind it does."""
    first = at
    while first and pieces[first - 1].token.type in _COMMENTS:
        first -= 1
    last = pieces[first - 1].token.type if first else "LBRACE"
    for piece in pieces[first:]:
        if piece.ended:
            return False
        if piece.token.type not in _COMMENTS:
            return piece.token.type != "RBRACE" and last not in ("LBRACE", "RBRACE")
    return False


def _space(left: Token, right: Token, gap: str) -> str:
    """What stands between two tokens of a line."""
    if right.type in _COMMENTS:
        return gap if len(gap) > 1 else "  "
    if left.type == "LBRACE" and right.type == "RBRACE":
        return " "
    if left.type in ("LPAR", "LSQB", "DOT") or right.type in ("COMMA", "RPAR", "RSQB", "DOT"):
        return ""
    if left.type == "COMMA" or left.type in APART or right.type in APART:
        return gap if len(gap) > 1 and "\t" not in gap else " "
    return gap.replace("\t", " ")

"""The message for a syntax error by the sentences of ``mistakes``, which stop the parser at the same place.

They are parsed once, when the first syntax error needs words; the state of the parser and the token at which each stops
are the key to its message.
"""

from __future__ import annotations

from functools import cache

from lark import Token, UnexpectedToken

from ..grammar import Machine
from .mistakes import MISTAKES, Mistake


def _wrapped(sentence: str) -> str:
    """A whole program that holds the sentence."""
    return sentence.removeprefix("top:") + "\n" if sentence.startswith("top:") else f"category C {{\n{sentence}\n}}\n"


@cache
def table(tools: Machine) -> dict[tuple[int, str], Mistake]:
    """State and token type to what to say."""
    found: dict[tuple[int, str], Mistake] = {}
    for mistake in MISTAKES:
        for sentence in mistake.sentences:
            where = stop(tools, sentence)
            if where is not None:
                found.setdefault(where, mistake)
    return found


def stop(tools: Machine, sentence: str) -> tuple[int, str] | None:
    """The state and the type of the token at which the parser stops in a sentence; None where it goes through."""
    text = _wrapped(sentence)
    error = tools.mistake(text)
    return key(error) if isinstance(error, UnexpectedToken) else None


def key(error: UnexpectedToken) -> tuple[int, str]:
    assert isinstance(error.token, Token)
    return error.interactive_parser.parser_state.position, error.token.type

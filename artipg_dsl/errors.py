"""Errors that the user can put right, with a clear message: what is wrong, and what to try."""

from __future__ import annotations


def printable(text: str) -> str:
    """A text that a terminal shows and does not obey: programs and folders of others end up in messages."""
    return "".join(c if c.isprintable() or c == "\n" else "\N{REPLACEMENT CHARACTER}" for c in text)


def plural(number: int, noun: str) -> str:
    """``1 object``, ``2 objects``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


FORCE = "--force (in Python force=True)"
"""What replaces what is there, as hints name it."""


class InternalError(Exception):
    """A fault of the compiler itself, found while it was at ``place``; the text asks for a report."""

    def __init__(self, place: object, what: str):
        super().__init__(f"{place}: {what}; this is a bug in apgc, please report it")
        self.place, self.what = place, what

    def __reduce__(self) -> tuple[type[InternalError], tuple[str, str]]:
        return type(self), (str(self.place), self.what)


class UserError(Exception):
    """``message`` says what is wrong, ``hint`` what to try."""

    def __init__(self, message: str, hint: str | None = None):
        super().__init__(f"{message} ({hint})" if hint else message)
        self.message, self.hint = message, hint

    def __reduce__(self) -> tuple[type[UserError], tuple[str, str | None]]:  # what another process raises arrives whole
        return type(self), (self.message, self.hint)


class UsageError(UserError, ValueError):
    """A wrong argument."""


class MissingName(UsageError, KeyError):
    """A name that nothing has, between brackets."""

    __str__ = Exception.__str__  # that of a KeyError shows quotes


class SettingError(UsageError):
    """A parameter that was to be set cannot be, or not to this value."""


class NoObject(UserError):
    """The requirements of a category leave nothing of some objects."""

"""Compiled programs (``.apgc``): the text of a constraint graph with its hash as the last line, read without the parser."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UserError
from ..graph.reading import TextError, from_text
from ..graph.writing import digest, to_text
from ..runtime.plan import PlanError
from ..sampling.sample import Sampler

if TYPE_CHECKING:
    from ..graph.program import Program

_LARGEST = 64 << 20  # bytes of a compiled program
_AGAIN = "compile it again from its .apg file"


def read_compiled(path: str | Path) -> Program:
    """The program that ``apgc compile -o`` wrote. Raises UserError."""
    try:
        with open(path, "rb") as file:
            found = file.read(_LARGEST + 1)
        if len(found) > _LARGEST:
            raise UserError(f"{path} is too large for a compiled program (more than {_LARGEST >> 20} MB)", _AGAIN)
        text = found.decode("utf-8").replace("\r\n", "\n")
        program = from_text(text)
    except FileNotFoundError:
        raise UserError(f"there is no file {path}", "`apgc compile NAME -o FILE.apgc` makes one") from None
    except OSError as error:
        raise UserError(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise UserError(f"{path}: this is not a compiled program", _AGAIN) from None
    except TextError as error:
        raise UserError(f"{path}: {error}", _AGAIN) from None
    except RecursionError:
        raise UserError(f"{path}: the compiled program is nested too deeply", _AGAIN) from None
    if not text.endswith(_seal(program.hash)):
        raise UserError(f"{path} has been changed or cut short since it was compiled", _AGAIN)
    return program


def make_sampler(program: Program, path: str | Path) -> Sampler:
    """What samples a compiled program. Raises UserError where it has no order of evaluation."""
    try:
        return Sampler(program)
    except PlanError as error:
        raise UserError(f"{path}: values depend on one another in a circle: {error}", _AGAIN) from None
    except RecursionError:
        raise UserError(f"{path}: the compiled program is nested too deeply", _AGAIN) from None


def to_compiled(program: Program, remarks: Sequence[str] = ()) -> str:
    """What a compiled file holds: the program, remarks as comments, and its hash as the last line."""
    told = "".join(f"# {' '.join(line.split())}".rstrip() + "\n" for line in remarks)
    return to_text(program) + told + _seal(digest(program))


def _seal(found: str) -> str:
    return f"# hash {found}\n"

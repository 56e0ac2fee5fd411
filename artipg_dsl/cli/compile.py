"""``apgc compile``: a program at one of the stages between its text and numbers.

The constraint graph is what an artefact holds: ``apgc compile NAME -o FILE.apgc``, then ``apgc sample FILE.apgc``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..diagnostics import CompileError
from ..errors import UsageError
from ..resources import COMPILED
from ..session import Session
from ..source import Span
from .arguments import STREAM
from .messages import findings, say

if TYPE_CHECKING:
    from ..syntax import ast


def of_text(name: str) -> Session:
    """The session of a program that is still text."""
    if Path(name).suffix == COMPILED:
        raise UsageError(f"{name} is a compiled program", "give the .apg file that it was compiled from")
    return Session.of(name)


def _emit_ast(session: Session) -> str | None:
    return None if session.tree is None else "\n".join(_tree_lines(session.tree)) + "\n"


def _emit_typed(session: Session) -> str | None:
    from ..semantics.show import show_typed

    typed = session.typed
    return None if typed is None or session.report.failed else show_typed(typed)


def emit_graph(session: Session) -> str | None:
    """The artefact, and before its hash, as comments, the blocks of equations that were solved."""
    from ..lower.solve.ledger import blocks
    from ..run.compiled import to_compiled

    _ = session.lowering  # the blocks of equations are not kept: it is compiled anew
    program, lowering = session.sampler.program, session.lowering
    assert lowering is not None
    lines = blocks((unknown for _, unknown in lowering.context.ledger), lowering.context.draws)
    return to_compiled(program, ["", "blocks of equations", *lines])


def _emit_plan(session: Session) -> str | None:
    return session.sampler.plan.source


def _emit_python(session: Session) -> str | None:
    from ..sampling.module import to_module
    from ..version import __version__

    return to_module(session.sampler.program, __version__)


EMITTERS: dict[str, Callable[[Session], str | None]] = {
    "ast": _emit_ast,
    "typed": _emit_typed,
    "graph": emit_graph,
    "plan": _emit_plan,
    "python": _emit_python,
}
"""A stage is an entry here and in ``options.texts.EMITS``. Each gives the text, None where findings stand in the way."""


def run(options: argparse.Namespace) -> int:
    session = of_text(options.program)
    if options.out is not None and Path(options.out).suffix == ".apg":
        raise UsageError(
            f"{options.out} is the name of a program, and a compiled program is not one",
            f"write {Path(options.out).with_suffix(COMPILED)}",
        )
    if options.out is not None and Path(options.out).suffix == COMPILED and options.emit != "graph":
        raise UsageError(
            f"{options.out} is the name of a compiled program, which --emit {options.emit} is not",
            "leave out --emit, or choose a name with another ending",
        )
    if options.force and options.out in (None, STREAM):
        raise UsageError("--force replaces a file, and none is written", "add -o FILE, or leave out --force")
    if options.out not in (None, STREAM):
        from ..export.write import require_place  # start-up: `apgc check` needs `of_text` alone

        require_place(Path(options.out), options.force)
    try:
        text = EMITTERS[options.emit](session)
    except CompileError:
        text = None
    findings(session.report.diagnostics, sys.stderr)
    if text is None:
        return 1
    if options.out in (None, STREAM):
        print(text, end="")
    else:
        from ..export.write import write_bytes  # start-up

        write_bytes(options.out, text.encode("utf-8"), force=options.force)
        say(f"wrote {options.out}")
    return 0


def _tree_lines(node: ast.Node, name: str = "", depth: int = 0) -> list[str]:
    """A tree with a node per line, its plain fields beside it and its children below."""
    from ..syntax import ast

    plain, below = [], []
    for field in fields(node):
        value: Any = getattr(node, field.name)
        items = value if isinstance(value, tuple) else (value,)
        if any(isinstance(item, ast.Node) for item in items):
            for item in items:
                if isinstance(item, ast.Node):
                    below += _tree_lines(item, field.name, depth + 1)
        elif value is not False and value not in (None, (), "") and not any(isinstance(item, Span) for item in items):
            plain.append(f"{field.name}={value!r}")
    head = f"{name}: " if name else ""
    place = f"{node.span.line}:{node.span.column}"
    return ["  " * depth + f"{head}{type(node).__name__} {place}" + "".join(" " + p for p in plain), *below]

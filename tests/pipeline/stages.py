"""A program at each stage between its text and an object, as text that people can review.

What is incidental is left out: places in the text, numbers of nodes, and what the library declares.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import MISSING, fields
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.cli.compile import EMITTERS
from artipg_dsl.diagnostics import Report
from artipg_dsl.export.registry import FORMATS
from artipg_dsl.graph import expr as E
from artipg_dsl.graph.program import Pose
from artipg_dsl.graph.show import is_short
from artipg_dsl.resources import library_dir
from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.runtime.plan import make_plan
from artipg_dsl.semantics.modules import Workspace
from artipg_dsl.session import Session
from artipg_dsl.source import Source
from artipg_dsl.syntax import ast
from artipg_dsl.syntax.parse import parse
from artipg_dsl.validity.mass import masses

HERE = Path(__file__).parent
PROGRAM = "program.apg"
HIDDEN = "..."
NODES, FEW = 40, 16  # a longer formula is not shown; nor one of so many that says where something is
LINES = 60  # of a plan are shown
POINTS = 200  # on which labels are counted
PLACES = ("low", "high", "origin", "points", "point", "frame", "center")
KINDS = (
    "requirements",
    "preferences",
    "parts",
    "links",
    "joints",
    "closures",
    "clear",
    "allowed",
    "stable",
    "sites",
    "slots",
    "labels",
    "grasps",
    "keypoints",
    "materials",
)
WITHOUT = {
    "requirements": ("slack", "message"),
    "parts": ("name",),
    "joints": ("name",),
    "sites": ("pose", "link", "scope"),
}
SAME = np.eye(3).tolist()


@cache
def compiled(name: str) -> Session:
    """The compilation of a program of these tests; modules of the library are parsed once for all of them."""
    session = Session.of_text((HERE / name / PROGRAM).read_text(encoding="utf-8"), PROGRAM)
    session.__dict__["workspace"] = Workspace(session.report, [library_dir()], loader=_parsed)
    return session


@cache
def _of_library(name: str, text: str) -> ast.Module | None:
    return parse(Source(name, text), Report())


def _parsed(source: Source, report: Report) -> ast.Module | None:
    return parse(source, report) if source.name == PROGRAM else _of_library(source.name, source.text)


# ---------------------------------------------------------------- tree and types


def tree(session: Session) -> str:
    """The syntax tree, a node a line, without places."""
    return re.sub(r"^(\s*(?:\w+: )?\w+) \d+:\d+", r"\1", _emitted("ast", session), flags=re.MULTILINE)


def typed(session: Session) -> str:
    """What the program's own declarations are."""
    return re.split(r"^(?=module )", _emitted("typed", session), flags=re.MULTILINE)[1]


def _emitted(stage: str, session: Session) -> str:
    text = EMITTERS[stage](session)
    assert text is not None, session.report.diagnostics
    return text


# ---------------------------------------------------------------- graph


def graph(session: Session) -> str:
    """The constraint graph, a record a line with its formulas written out, then how its equations were solved."""
    program = session.sampler.program
    lines = [f"{_named(scope)}: {_table(scope)}" for scope in program.scopes]
    lines += [f"draw {_fields(draw, ('address',))}" for draw in program.draws]
    lines += [f"define {column.path} = {_formula(value)}" for column, value in program.definitions.items()]
    for kind in KINDS:
        held = getattr(program, kind)
        for item in held.values() if isinstance(held, dict) else held:
            lines.append(f"{kind.removesuffix('s')} {_fields(item, WITHOUT.get(kind, ()))}")
    for primitive in program.primitives.values():
        if primitive.where.startswith(PROGRAM):
            lines.append(f"primitive {_fields(primitive, ('patches', 'pieces'))}")
            shown = [(patch.name, _fields(patch)) for patch in primitive.patches]
            lines += [f"  surface {text}" for _, text in shown if HIDDEN not in text]
            hidden = Counter(name for name, text in shown if HIDDEN in text)
            lines += [f"  surface {name} of {count} longer formulas" for name, count in hidden.items()]
            corners = Counter(len(piece.points) for piece in primitive.pieces)
            lines += [f"  {count} pieces of {most} corners" for most, count in sorted(corners.items())]
    _, _, solved = _emitted("graph", session).partition("# blocks of equations\n")
    lines += [f"solved {line[2:]}" for line in solved.splitlines() if not line.startswith("# hash")]
    return re.sub(rf" \({PROGRAM}:[\d:]+\)", "", "\n".join(lines)) + "\n"


def _named(scope: E.Scope) -> str:
    return f"table {scope.name}"


def _table(scope: E.Scope) -> str:
    return scope.kind if scope.count is None else f"{scope.kind}, {_formula(scope.count)} rows"


def _fields(record: Any, without: Iterable[str] = ()) -> str:
    """The fields of a record that say something: places, documentation and defaults do not."""
    words = []
    for field in fields(record):
        value = getattr(record, field.name)
        default = field.default_factory() if field.default_factory is not MISSING else field.default
        silent = value is E.TRUE or value is default or type(value) is type(default) and value == default
        if not silent and field.name not in ("where", "doc", *without):
            text = _shown(value, FEW if field.name in PLACES else NODES)
            words.append(text if field.name in ("path", "name", "column") else f"{field.name} {text}")
    return "  ".join(words)


def _shown(value: Any, nodes: int = NODES) -> str:
    if isinstance(value, E.Expr):
        return _formula(value, nodes)
    if isinstance(value, E.Column):
        return value.path
    if isinstance(value, E.Scope):
        return value.name
    if isinstance(value, Pose):
        return _pose(value)
    if isinstance(value, (list, tuple)):
        items = [_shown(item, nodes) for item in value]
        return HIDDEN if set(items) == {HIDDEN} else f"[{', '.join(items)}]"
    if hasattr(value, "__dataclass_fields__"):
        return f"({_fields(value)})"
    return str(value)


def _pose(pose: Pose) -> str:
    """The place, and the directions of the axes where they are not those of the object."""
    turned = [[a.constant for a in row] for row in pose.rotation] != SAME
    text = _shown(pose.translation, FEW) + (f" axes {_shown(pose.rotation, FEW)}" if turned else "")
    return text + ("" if pose.mirror.constant == 1.0 else f" mirror {_formula(pose.mirror)}")


def _formula(node: E.Expr, nodes: int = NODES) -> str:
    if not is_short(node, nodes):
        return HIDDEN
    text = E.show(node)
    return text[1:-1] if re.fullmatch(r"\([^()]*\)", text) else text


# ---------------------------------------------------------------- plan


def plan(session: Session) -> str:
    """The generated code of what is drawn, required and defined; that of poses and boxes follows the same rules."""
    program = session.sampler.program
    wanted = [(E.col(column), column.scope) for column in program.definitions]
    lines = re.sub(r"  # library/.*", "", make_plan(program, wanted).source).splitlines()
    begin = lines.index("    values = [")
    values = "    values = [" + " ".join(line.strip() for line in lines[begin + 1 : -2]).rstrip(",") + "]"
    code = lines[:begin]
    if len(code) > LINES:
        code[LINES:] = [f"    ... {len(code) - LINES} lines more"]
    return "\n".join([*code, values, lines[-1], ""])


# ---------------------------------------------------------------- sample


def sample(session: Session) -> str:
    """Object 0 with seed 0, rounded: what was drawn, parts, joints, labels at points, grasps."""
    batch = session.sampler.batch(np.arange(1), 0, checked=True)
    (told,) = annotate(batch, gripper=None)
    lines = [f"attempt {told['rejected']}"]
    lines += [f"drawn {name} = {_rounded(value)}" for name, value in told["drawn"].items()]
    for link, mass in zip(told["links"], masses(batch).mass, strict=True):
        lines.append(f"link {link['name']}  {mass * 1000.0:.1f} g")
    for kind in ("parts", "joints", "grasps", "keypoints", "interactions"):
        lines += [f"{kind.removesuffix('s')} {_row(row)}" for row in told[kind]]
    if batch.program.labels:
        lines += _labelled(batch)
    return "\n".join(lines) + "\n"


def _row(row: dict[str, Any]) -> str:
    """A row of an annotation without what is empty, doubled or as it is as a rule."""
    plain = {"quaternion": [1, 0, 0, 0], "rest": 0, "reachable": True}
    doubled = ("number", "path", "lineage", "scale", "of")
    words = []
    for key, value in row.items():
        if value not in (None, [], {}) and key not in doubled and value != plain.get(key):
            words.append(_rounded(value) if key == "name" else f"{key} {_rounded(value)}")
    return "  ".join(words)


def _rounded(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float, list, dict)):
        return str(value)
    if isinstance(value, dict):
        return " ".join(f"{key} {_rounded(inner)}" for key, inner in value.items())
    if isinstance(value, list):
        return "[" + ", ".join(map(_rounded, value)) + "]"
    return f"{round(value, 4) + 0.0:.4f}".rstrip("0").rstrip(".")


def _labelled(batch: Batch) -> Iterator[str]:
    """How many of some points have each word, and the mean of what has a value."""
    points = sample_points(batch, POINTS)
    words = batch.program.vocabularies.get("semantic", ())
    for number, word in enumerate(words[1:], 1):
        yield f"semantic.{word} at {(points.semantic == number).sum()} of {POINTS} points"
    for name, values in points.labels.items():
        if values.dtype == bool:
            yield f"{name} at {values.sum()} of {POINTS} points"
        else:
            yield f"{name} at {(np.nan_to_num(values) != 0).sum()} of {POINTS} points, {_rounded(float(np.nanmean(values)))} on average"


# ---------------------------------------------------------------- file


def urdf(session: Session) -> str:
    """Object 0 as URDF."""
    files = FORMATS["urdf"].files(Robots(session.sampler.batch(np.arange(1), 0, checked=True)), 0)
    return files[FORMATS["urdf"].file].decode()


STAGES: dict[str, Callable[[Session], str]] = {
    "tree": tree,
    "typed": typed,
    "graph": graph,
    "plan": plan,
    "sample": sample,
}
"""The files beside a program, ``tree.txt`` and so on."""

SHOWN = "chest"  # the program of docs/architecture.md
MORE: dict[str, Callable[[Session], str]] = {"urdf": urdf}
"""What that page shows besides."""


def stages(name: str) -> dict[str, Callable[[Session], str]]:
    return STAGES | MORE if name == SHOWN else STAGES


__all__ = ["HERE", "PROGRAM", "SHOWN", "STAGES", "compiled", "stages"]

"""A program as a Python module that needs NumPy alone."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterable
from types import ModuleType
from typing import Any

from jinja2 import Environment, PackageLoader

from .. import random
from ..graph.expr import Expr, Scope
from ..graph.program import Program
from ..graph.writing import digest
from ..runtime import draws, kernels, laws, newton
from ..runtime.needs import pose_cells
from ..runtime.plan import Plan, make_plan
from .statistics import ATTEMPTS


def to_module(program: Program, version: str) -> str:
    """Python source of the module."""
    wanted = []
    for site in program.sites:
        wanted += [(e, site.scope) for e in (*site.parameters, *pose_cells(site.pose))]
    for joint in program.joints:
        limits = [e for e in (joint.low, joint.high) if e is not None]
        wanted += [(e, joint.scope) for e in (*joint.origin, *joint.axis, *limits)]
    plan = make_plan(program, wanted)
    sites = [
        (
            site.path,
            site.primitive,
            plan.scopes[site.scope],
            program.primitives[site.primitive].parameters,
            _indices(plan, site.parameters, site.scope),
            _indices(plan, pose_cells(site.pose), site.scope),
        )
        for site in program.sites
    ]
    joints = [
        (
            joint.path,
            joint.kind,
            plan.scopes[joint.scope],
            _indices(plan, joint.origin, joint.scope),
            _indices(plan, joint.axis, joint.scope),
            _limit(plan, joint.low, joint.scope),
            _limit(plan, joint.high, joint.scope),
        )
        for joint in program.joints
    ]
    environment = Environment(loader=PackageLoader("artipg_dsl.sampling"), keep_trailing_newline=True, autoescape=False)
    return environment.get_template("module.py.j2").render(
        program=program,
        version=version,
        hash=digest(program),
        plan=plan,
        scopes=plan.scopes,
        sites=sites,
        joints=joints,
        random=_body(random),
        kernels="\n\n".join(_body(m) for m in (laws, kernels, draws)),
        newton=_body(newton),
        attempts=ATTEMPTS,
        about=_spoken(program.doc),
        name=" ".join(_spoken(program.name).split()),
    )


def _indices(plan: Plan, exprs: Iterable[Expr], scope: Scope) -> tuple[Any, ...]:
    """Output indices of expressions; a constant as a tuple of its value."""
    return tuple((e.value,) if e.op == "const" else plan.outputs[e, scope] for e in exprs)


def _limit(plan: Plan, expr: Expr | None, scope: Scope) -> Any:
    return None if expr is None else _indices(plan, (expr,), scope)[0]


def _spoken(text: str) -> str:
    """A text that can stand in a docstring or in a comment, whatever is in it; only the lines stay lines."""
    plain = text.replace("\\", "\\\\").replace('"', "'")
    return "".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in plain)


def _body(module: ModuleType) -> str:
    """The source of a module behind its docstring and imports."""
    text = inspect.getsource(module)
    imports = [node for node in ast.parse(text).body if isinstance(node, ast.Import | ast.ImportFrom)]
    return "\n".join(text.split("\n")[imports[-1].end_lineno :]).strip("\n") + "\n"

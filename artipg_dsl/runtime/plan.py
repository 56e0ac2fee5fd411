"""From a program to straight-line NumPy code: tables, draws and definitions in one order of dependence.

The generated function ``evaluate(state, want)`` returns the tables and one array per output, an output being an
expression in a scope. What no output, draw or requirement needs is not computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field
from typing import Any

from ..garbage import uncollected
from ..graph.expr import CROSSING, Column, Expr, Scope, both, call, negate, show
from ..graph.formula import literal, source
from ..graph.order import bottom_up
from ..graph.program import Bound, Draw, Program, Union
from ..records import dataclass
from .lines import Argument, Call, Line, Step, taped, whole


class PlanError(Exception):
    """A program that cannot be put in order (a value needs itself)."""


@dataclass(slots=True, eq=False)
class Plan:
    """``source`` is the generated code; ``outputs`` the index of each (expression, scope) among its results."""

    program: Program
    lines: list[Line]
    tables: list[str]  # their names
    values: list[str]  # of the outputs: names and numbers
    outputs: dict[tuple[Expr, Scope], int]
    scopes: dict[Scope, int]
    loose: tuple[
        tuple[int, Bound], ...
    ]  # bounds that would have needed a later draw: left to the check of requirements
    _function: Callable[..., Any] | None = None
    _bare: Plan | None = None
    _more: dict[tuple[tuple[Expr, Scope], ...], Plan] = field(default_factory=dict)

    @property
    def bare(self) -> Plan:
        """The plan of draws, requirements and preferences alone."""
        if self._bare is None:
            self._bare = make_plan(self.program, ())
        return self._bare

    def also(self, wanted: tuple[tuple[Expr, Scope], ...]) -> Plan:
        """The plan of what this one does not give; one for all batches that ask for it."""
        if wanted not in self._more:
            self._more[wanted] = make_plan(self.program, wanted)
        return self._more[wanted]

    @property
    def source(self) -> str:
        """The whole as Python."""
        return whole(self.lines, self.tables, self.values)

    @property
    def function(self) -> Callable[..., Any]:
        if self._function is None:
            from . import draws, evaluation, kernels, newton  # start-up: a plan is made and shown without them

            with uncollected():
                lines, tapes = taped(self.lines, self.values)
                known = {**vars(kernels), **vars(draws), "solve_roots": newton.solve_roots, **tapes}
                self._function = evaluation.Evaluation(lines, self.tables, self.values, known)
        return self._function


@dataclass(slots=True, eq=False)
class _Emitter:
    program: Program
    lines: list[Line] = field(default_factory=list)
    names: dict[Expr, str] = field(default_factory=dict)
    gathered: dict[tuple[str, Scope], str] = field(default_factory=dict)
    tables: dict[Scope, str] = field(default_factory=dict)
    routes: dict[tuple[Scope, Scope], str] = field(default_factory=dict)
    draws: dict[Column, int] = field(default_factory=dict)
    drawn: dict[Column, str] = field(default_factory=dict)
    running: list[object] = field(default_factory=list)
    loose: list[tuple[int, Bound]] = field(default_factory=list)
    scalars: set[str] = field(default_factory=set)  # names that hold one number for all rows
    counter: int = 0

    def scalar(self, name: str) -> bool:
        return name in self.scalars or not name[0].isalpha() or name in ("True", "False") or name.startswith("np.")

    def remark(self, text: str) -> None:
        """A comment behind the last line, which is a call."""
        last = self.lines[-1]
        assert isinstance(last, Call)
        self.lines[-1] = last._replace(remark=text)

    def does(self, function: str, *arguments: Argument) -> None:
        self.lines.append(Call((), function, arguments))

    def fresh(self, function: str, *arguments: Argument, letter: str = "x") -> str:
        name = self.name(letter)
        self.lines.append(Call((name,), function, arguments))
        return name

    def step(self, op: str, arguments: list[str], scope: Scope | None) -> str:
        name = self.name()
        if all(map(self.scalar, arguments)):
            self.scalars.add(name)
        self.lines.append(Step(name, op, tuple(arguments), None if name in self.scalars else scope))
        return name

    def name(self, letter: str = "x") -> str:
        self.counter += 1
        return f"{letter}{self.counter - 1}"

    # ------------------------------------------------------------ tables

    def table(self, scope: Scope) -> str:
        name = self.tables.get(scope)
        if name is None:
            if scope.parent is None:
                name = self.fresh("root_rows", "state", letter="T")
            else:
                assert scope.count is not None
                parent = self.table(scope.parent)
                count = self.value(scope.count, scope.parent)
                name = self.fresh("child_rows", "state", parent, count, str(scope.kind == "guard"), letter="T")
            self.remark(scope.name)
            self.tables[scope] = name
        return name

    def route(self, above: Scope, below: Scope) -> str:
        """Row of ``above`` for each row of ``below``."""
        name = self.routes.get((above, below))
        if name is None:
            table = self.table(below)
            if below.parent is above:
                name = f"{table}.parent"
            else:
                assert below.parent is not None
                name = self.fresh("take", self.route(above, below.parent), f"{table}.parent", letter="g")
            self.routes[above, below] = name
        return name

    def value(self, node: Expr, scope: Scope | None) -> str:
        """An expression in the rows of ``scope`` (a scalar where it is one)."""
        name = self.node(node)
        if node.scope is None or scope is None or node.scope is scope or self.scalar(name):
            return name
        key = (name, scope)
        found = self.gathered.get(key)
        if found is None:
            found = self.gathered[key] = self.fresh("take", name, self.route(node.scope, scope))
        return found

    # ------------------------------------------------------------ nodes

    def node(self, node: Expr) -> str:
        if node not in self.names:
            for at in bottom_up(node, _made_before, self.names):
                self.names[at] = self.make(at)
        return self.names[node]

    def make(self, node: Expr) -> str:
        if node.op == "const":
            return literal(node.value)
        if node.op == "col":
            return self.column(node.value)
        if node.op == "rank":
            assert node.scope is not None
            return self.fresh("ranks", self.table(node.scope))
        if node.op == "phi":
            return self.phi(node)
        if node.op in ("reduce", "element", "previous", "scan"):
            return self.crossing(node)
        if node.op == "solve":
            return self.solve(node)
        if node.op == "root":
            found = self.node(node.args[0])
            name = self.fresh("take", found, str(int(node.value[0])))
            if self.scalar(found):
                self.scalars.add(name)
            return name
        if node.op == "var":
            raise PlanError(f"the variable {node.value} is outside a formula")
        arguments = [self.value(a, node.scope) for a in node.args]
        if node.scope is not None:
            self.table(node.scope)
        return self.step(node.op, arguments, node.scope)

    def phi(self, node: Expr) -> str:
        scopes: tuple[Scope, ...] = node.value
        assert node.scope is not None
        parent = self.table(node.scope)
        default = self.value(node.args[-1], node.scope)
        branches = [
            (self.table(scope), self.value(value, scope)) for scope, value in zip(scopes, node.args[:-1], strict=True)
        ]
        return self.fresh("merge", parent, default, tuple(branches))

    def solve(self, node: Expr) -> str:
        """Equations solved together: a function of the block, and the call that searches from its starts."""
        size, known = node.value
        formulas, values = node.args[: size + size * size], node.args[size + size * size :]
        arguments = [self.value(a, node.scope) for a in values]
        names = [f"solve.x{k}" for k in range(size)] + [f"solve.p{k}" for k in range(known)]
        function = f"f{self.counter}"
        self.lines += [f"    {line}" for line in source(formulas, names, function).split("\n")]
        name = self.fresh("solve_roots", function, tuple(arguments[known:]), tuple(arguments[:known]))
        if all(map(self.scalar, arguments)):
            self.scalars.add(name)
        return name

    def crossing(self, node: Expr) -> str:
        if node.op == "reduce":
            kind, child = node.value
            return self.fresh("reduce_rows", repr(kind), self.table(child), self.value(node.args[0], child))
        scope: Scope = node.value
        table, value = self.table(scope), self.value(node.args[0], scope)
        if node.op == "element":
            return self.fresh("pick_row", table, value, self.value(node.args[1], node.scope))
        if node.op == "previous":
            return self.fresh("row_before", table, value, self.value(node.args[1], scope))
        return self.fresh("running_sum", table, value)

    # ------------------------------------------------------------ columns

    def column(self, column: Column) -> str:
        definition = self.program.definitions.get(column)
        if definition is not None:
            self.enter(column)
            name = self.value(definition, column.scope)
            self.running.pop()
            return name
        if column not in self.drawn:
            if column not in self.draws:
                raise PlanError(f"nothing gives {column.path} a value")
            self.enter(column)
            self.draw(self.draws[column], self.program.draws[self.draws[column]])
            self.running.pop()
        return self.drawn[column]

    def enter(self, column: Column) -> None:
        if column in self.running:
            chain = " -> ".join(c.path for c in self.running[self.running.index(column) :])  # type: ignore[attr-defined]
            raise PlanError(f"{chain} -> {column.path}")
        self.running.append(column)

    def draw(self, number: int, draw: Draw) -> None:
        scope = draw.column.scope
        table = self.table(scope)
        if draw.kind == "choice":
            plain = [self.value(w, scope) for w in draw.weights]
            left = [self.limited(draw, k, w) for k, w in enumerate(plain)]
            declared = tuple(plain) if left != plain else "None"
            usual = "None" if draw.default is None else self.value(draw.default, scope)
            function = "draw_choice"
            law: tuple[Argument, ...] = (tuple(left), declared, usual)
        else:
            assert draw.low is not None and draw.high is not None
            least, most = self.value(draw.low, scope), self.value(draw.high, scope)
            low, high = self.fresh("widened", table, least), self.fresh("widened", table, most)
            for bound in draw.bounds:
                self.bound(number, bound, scope, low, high)
            unions = tuple(found for union in draw.unions if (found := self.union(union, scope)))
            default = "None" if draw.default is None else self.value(draw.default, scope)
            arguments = tuple(self.value(a, scope) for a in draw.arguments)
            function = "draw_count" if draw.kind == "count" else "draw_real"
            law = (low, high, repr(draw.distribution), arguments, default, (least, most), unions)
        name = self.fresh(function, "state", table, str(number), repr(draw.address), *law)
        self.remark(draw.column.path)
        self.drawn[draw.column] = name

    def limited(self, draw: Draw, option: int, weight: str) -> str:
        """The weight of an option, 0 where a requirement excludes it."""
        for limit in draw.limits:
            if limit.option == option:
                found = self.early(limit.allowed, draw.column.scope)
                if found is not None:
                    weight = self.step("where", [found, weight, "0.0"], draw.column.scope)
        return weight

    def early(self, node: Expr, scope: Scope) -> str | None:
        """A value if it is known before what is being drawn; None (and nothing emitted) if it is not."""
        stacks: tuple[list[Any], ...] = (self.lines, self.running)
        known: tuple[dict[Any, Any], ...] = (self.names, self.gathered, self.tables, self.routes, self.drawn)
        lengths, sizes = [len(stack) for stack in stacks], [len(names) for names in known]
        try:
            return self.value(node, scope)
        except PlanError:
            for stack, length in zip(stacks, lengths, strict=True):
                del stack[length:]
            for names, size in zip(known, sizes, strict=True):
                while len(names) > size:  # what was added last; nothing that was known before has changed
                    names.popitem()
            return None

    def union(self, union: Union, scope: Scope) -> tuple[Argument, ...]:
        """A union of intervals as the kernels take it; nothing where it needs what is drawn later."""
        found = [self.early(node, scope) for node in (union.guard, *(end for pair in union.intervals for end in pair))]
        known = [name for name in found if name is not None]
        if len(known) < len(found):
            return ()
        return known[0], tuple(zip(known[1::2], known[2::2], strict=True))

    def bound(self, number: int, bound: Bound, scope: Scope, low: str, high: str) -> None:
        """Narrow a draw; a bound that needs what is drawn later is left to the check."""
        value = self.early(bound.value, scope)
        guard = None if value is None else self.early(bound.guard, scope)
        if value is None or guard is None:
            self.loose.append((number, bound))
            return
        self.does("narrow", low, high, repr(bound.side), value, guard)


_OTHERWISE = CROSSING | {"col", "solve", "root"}


def _made_before(node: Expr) -> Iterator[Expr]:
    """The arguments that are asked for before the first line that fetches one from another table."""
    for arg in () if node.op in _OTHERWISE else node.args:
        yield arg
        if arg.scope is not None and arg.scope is not node.scope:
            return


def make_plan(program: Program, wanted: Iterable[tuple[Expr, Scope]]) -> Plan:
    """Plan the evaluation of a program with the given outputs."""
    emitter = _Emitter(program)
    emitter.draws = {d.column: k for k, d in enumerate(program.draws)}
    emitter.table(program.scopes[0])
    for draw in program.draws:
        emitter.column(draw.column)
    for number, requirement in enumerate(program.requirements):
        holds = requirement.condition
        if requirement.slack is not None:
            holds = call("le", requirement.slack[0], requirement.slack[1] + 1e-9)
        holds = negate(both(requirement.guard, negate(holds)))
        value = emitter.value(holds, requirement.scope)
        emitter.does("demand", "state", emitter.table(requirement.scope), str(number), value)
        emitter.remark(str(requirement.where))
    for number, preference in enumerate(program.preferences):
        scope = preference.scope
        holds = negate(both(preference.guard, negate(preference.condition)))
        told = emitter.value(holds, scope), emitter.value(preference.weight, scope)
        emitter.does("lean", "state", emitter.table(scope), str(number), *told)
        emitter.remark(str(preference.where))
    outputs: dict[tuple[Expr, Scope], int] = {}
    values: list[str] = []
    for expr, scope in wanted:
        if (expr, scope) not in outputs:
            outputs[expr, scope] = len(values)
            values.append(emitter.value(expr, scope))
    for scope in program.scopes:
        emitter.table(scope)
    tables = [emitter.tables[scope] for scope in program.scopes]
    scopes = {s: k for k, s in enumerate(program.scopes)}
    return Plan(program, emitter.lines, tables, values, outputs, scopes, tuple(emitter.loose))


__all__ = ["Plan", "PlanError", "make_plan", "show"]

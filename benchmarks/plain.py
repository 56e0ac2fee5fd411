# ruff: noqa: E402 - the number of threads is set before NumPy is loaded
"""Objects resolved one by one in plain Python floats, beside all of them as columns, in one run.

The loop is what one would write for a single category: straight-line Python, generated from the same expressions, a function
that takes the drawn values of an object and returns its tables. No NumPy: numbers are floats, a value of a repeated part is a
list. What is used once stands where it is used, equal subexpressions are computed once, branches that are not taken are not
computed. It is given what was drawn; columns draw as well, so the ratios are in favour of the loop. `rows` is the loop that
`main_job.py` has: NumPy on batches of one object.

The values are compared with those of the columns before anything is timed: equal but for the last bits of sines, cosines, roots of
powers and the like, in which NumPy and the library of mathematics differ (within 1e-9, of lengths of metres).
Rounds take turns; microseconds of CPU an object, the least of the rounds. Categories with equations that are solved by
search have no such loop and are left out.

    python benchmarks/plain.py [-n 1024] [--few 64] [--rounds 5] [-o plain.json] [Microwave ...]
"""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"

import argparse
import json
import math
import time
from collections import Counter
from collections.abc import Callable
from itertools import accumulate
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from artipg_dsl.graph.expr import Column, Expr, Scope
from artipg_dsl.graph.program import Program
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session, categories

CLOSE = 1e-9
LONGEST = 300  # characters of an expression that stands where it is used
PLAIN = {
    "add": "({0} + {1})",
    "sub": "({0} - {1})",
    "mul": "({0} * {1})",
    "div": "divide({0}, {1})",
    "neg": "(-{0})",
    "pow": "power({0}, {1})",
    "abs": "abs({0})",
    "sqrt": "sqrt({0})",
    "sin": "sin({0})",
    "cos": "cos({0})",
    "tan": "tan({0})",
    "asin": "asin({0})",
    "acos": "acos({0})",
    "atan": "atan({0})",
    "atan2": "atan2({0}, {1})",
    "hypot": "hypot({0}, {1})",
    "exp": "exp({0})",
    "log": "log({0})",
    "floor": "float(floor({0}))",
    "ceil": "float(ceil({0}))",
    "sign": "sign({0})",
    "min": "min({0}, {1})",
    "max": "max({0}, {1})",
    "mod": "({0} % {1})",
    "lt": "({0} < {1})",
    "le": "({0} <= {1})",
    "eq": "({0} == {1})",
    "and": "({0} and {1})",
    "or": "({0} or {1})",
    "not": "(not {0})",
    "where": "({1} if {0} else {2})",
}
EMPTY = {"sum": "0.0", "min": "inf", "max": "-inf", "any": "False", "all": "True"}


class NotPlain(Exception):
    """A program for which there is no such loop."""


def lenient(function: Callable[..., float]) -> Callable[..., float]:
    """Not a number where there is none, as columns have it: such values are computed, and not taken."""

    def found(*values: float) -> float:
        try:
            return function(*values)
        except (ValueError, ZeroDivisionError, OverflowError):
            return math.nan

    return found


def divide(a: float, b: float) -> float:
    return a / b if b else (math.nan if a == 0.0 or a != a else math.copysign(math.inf, a))


KNOWN: dict[str, Any] = {name: lenient(getattr(math, name)) for name in ("sqrt", "asin", "acos", "log", "exp")}
KNOWN |= {
    name: getattr(math, name) for name in ("sin", "cos", "tan", "atan", "atan2", "hypot", "floor", "ceil", "inf", "nan")
}
KNOWN |= {"divide": divide, "power": lenient(pow), "sign": lambda a: float((a > 0) - (a < 0))}


class Writer:
    """Writes the function of a program: ``resolve(drawn)`` gives the values of ``wanted``, expressions in scopes."""

    def __init__(self, program: Program, wanted: list[tuple[Expr, Scope]]):
        self.program, self.lines = program, ["def resolve(drawn):"]
        self.number = {draw.column: k for k, draw in enumerate(program.draws)}
        self.names: dict[Any, str] = {}
        self.waiting: dict[str, tuple[str, list[str]]] = {}  # what stands where it is used: its text, the lists in it
        self.tokens = 0
        self.lists: set[str] = set()  # names of values that have one for each row
        self.uses: Counter[Expr] = Counter()
        for expr in [*(expr for expr, _ in wanted), *(s.count for s in program.scopes if s.count is not None)]:
            self._count(expr)
        results = [self.value(expr, scope) for expr, scope in wanted]
        self.lines.append(f"    return [{', '.join(results)}]")
        namespace = dict(KNOWN)
        exec(compile("\n".join(self.lines), "<plain>", "exec"), namespace)  # noqa: S102 - no text of a program reaches it
        self.resolve: Callable[[list[Any]], list[Any]] = namespace["resolve"]

    def _count(self, node: Expr) -> None:
        waiting = [node]
        while waiting:
            own = waiting.pop()
            self.uses[own] += 1
            if self.uses[own] == 1:
                waiting.extend(own.args)
                if own.op == "col" and own.value in self.program.definitions:
                    waiting.append(self.program.definitions[own.value])

    def put(self, text: str) -> str:
        name = f"x{len(self.lines)}"
        self.lines.append(f"    {name} = {text}")
        return name

    def once(self, key: Any, make: Callable[[], str]) -> str:
        if key not in self.names:
            self.names[key] = make()
        return self.names[key]

    # ------------------------------------------------------------ tables: how many rows, and whose

    def counts(self, scope: Scope) -> str:
        """The number of rows per row of the parent: a number below the root, else a list."""
        assert scope.parent is not None and scope.count is not None
        own, one = self.value(scope.count, scope.parent), scope.parent.parent is None
        return self.once(
            (scope, "counts"),
            lambda: self.put(f"int({own})" if one else f"[int(c) for c in {self.listed(own, scope.parent)}]"),
        )

    def parent(self, scope: Scope) -> str:
        """The row of the parent of each row; below the root there is none but the root's."""
        count, one = self.counts(scope), scope.parent is None or scope.parent.parent is None
        text = f"[0] * {count}" if one else f"[k for k, c in enumerate({count}) for _ in range(c)]"
        return self.once((scope, "parent"), lambda: self.put(text))

    def size(self, scope: Scope) -> str:
        return f"len({self.parent(scope)})" if scope.parent is not None else "1"

    def listed(self, value: str, scope: Scope) -> str:
        """A value as a list in the rows of a scope."""
        return value if value in self.lists else f"[{value}] * {self.size(scope)}"

    def children(self, scope: Scope, value: str) -> str:
        """The values of the rows of each row of the parent, a list of lists; below the root one list."""
        assert scope.parent is not None
        whole = self.listed(value, scope)
        if scope.parent.parent is None:
            return whole
        return f"parted({whole}, {self.counts(scope)})"

    # ------------------------------------------------------------ values

    def value(self, node: Expr, scope: Scope | None) -> str:
        """An expression in the rows of ``scope``: a list, or one number for all of them."""
        found = self.node(node)
        if found not in self.lists or scope is None or node.scope is scope:
            return found
        assert node.scope is not None and scope.parent is not None
        above = scope.parent
        own = self.value(node, above)

        def gather() -> str:
            name = self.put(f"[{own}[k] for k in {self.parent(scope)}]")
            self.lists.add(name)
            return name

        return self.once((own, scope, "gathered"), gather)

    def node(self, node: Expr) -> str:
        found = self.once(node, lambda: self.make(node))
        if found in self.waiting:
            found = self.names[node] = self.listing(self.comprehension(*self.waiting.pop(found)))
        return found

    @staticmethod
    def comprehension(text: str, many: list[str]) -> str:
        rows = many[0] if len(many) == 1 else f"zip({', '.join(many)})"
        return f"[{text} for {', '.join(name + '_' for name in many)} in {rows}]"

    def listing(self, text: str) -> str:
        name = self.put(text)
        self.lists.add(name)
        return name

    def make(self, node: Expr) -> str:
        if node.op == "const":
            return repr(node.value) if math.isfinite(node.value) and node.value >= 0 else f"({node.value!r})"
        if node.op == "col":
            return self.column(node.value)
        scope = node.scope
        assert scope is not None
        if node.op == "rank":
            count = self.counts(scope)
            assert scope.parent is not None
            flat = f"range({count})" if scope.parent.parent is None else f"(r for c in {count} for r in range(c))"
            return self.listing(f"[float(r) for r in {flat}]")
        if node.op == "phi":
            return self.phi(node)
        if node.op == "reduce":
            kind, child = node.value
            rows = self.children(child, self.value(node.args[0], child))
            if scope.parent is None:
                return self.put(self.reduced(kind, rows))
            return self.listing(f"[{self.reduced(kind, 'rows')} for rows in {rows}]")
        if node.op in ("element", "previous", "scan"):
            return self.crossing(node, scope)
        if node.op in PLAIN:
            return self.combined(node, scope)
        raise NotPlain(node.op)

    @staticmethod
    def reduced(kind: str, rows: str) -> str:
        return (
            f"sum({rows}, 0.0)"
            if kind == "sum"
            else f"{kind}({rows})"
            if kind in ("any", "all")
            else f"{kind}({rows}, default={EMPTY[kind]})"
        )

    def combined(self, node: Expr, scope: Scope) -> str:
        """An operation: where its value is used once it waits to stand there."""
        many, texts = list[str](), []
        for arg in node.args:
            own = self.once(arg, lambda arg=arg: self.make(arg)) if arg.scope is scope else self.value(arg, scope)
            text, rows = self.waiting.pop(own) if own in self.waiting else (own, [])
            if own in self.lists:
                text, rows = f"{own}_", [own]
            texts.append(text)
            many += [name for name in rows if name not in many]
        text = PLAIN[node.op].format(*texts)
        short = self.uses[node] == 1 and len(text) < LONGEST
        if not many:
            return text if short else self.put(text)
        if not short:
            return self.listing(self.comprehension(text, many))
        self.tokens += 1
        name = f"w{self.tokens}"
        self.waiting[name] = text, many
        return name

    def crossing(self, node: Expr, scope: Scope) -> str:
        """What a row has from its siblings, or its parent from the one of a number."""
        table: Scope = node.value
        assert table.parent is not None
        rows, one = self.children(table, self.value(node.args[0], table)), table.parent.parent is None
        if node.op == "element":
            index = self.value(node.args[1], scope)
            if one:
                return self.put(f"picked({rows}, {index})")
            return self.listing(f"[picked(*pair) for pair in zip({rows}, {self.listed(index, scope)})]")
        if node.op == "scan":
            whole = f"summed({rows})" if one else f"[v for rows in {rows} for v in summed(rows)]"
            return self.listing(whole)
        first = self.children(table, self.value(node.args[1], table))
        if one:
            return self.listing(f"{first}[:1] + {rows}[:-1]")
        return self.listing(f"[v for a, rows in zip({first}, {rows}) for v in a[:1] + rows[:-1]]")

    def phi(self, node: Expr) -> str:
        """Per row the value of the guarded row that is there, else the default."""
        scope: Scope = node.scope  # type: ignore[assignment]
        default = self.value(node.args[-1], scope)
        branches = [(own, self.value(arg, own)) for own, arg in zip(node.value, node.args[:-1], strict=True)]
        if scope.parent is None:
            text = default
            for own, value in branches:
                text = f"({value}{'[0]' if value in self.lists else ''} if {self.counts(own)} else {text})"
            return self.put(text)
        name = self.listing(f"list({default})" if default in self.lists else self.listed(default, scope))
        for own, value in branches:
            pairs = f"zip({self.parent(own)}, {self.listed(value, own)})"
            self.lines.append(f"    for k, a in {pairs}: {name}[k] = a")
        return name

    def column(self, column: Column) -> str:
        definition = self.program.definitions.get(column)
        if definition is not None:
            return self.value(definition, column.scope)
        if column.scope.parent is None:
            return self.put(f"drawn[{self.number[column]}][0]")
        return self.listing(f"drawn[{self.number[column]}]")


def parted(values: list[Any], counts: list[int]) -> list[list[Any]]:
    found, start = [], 0
    for count in counts:
        found.append(values[start : start + count])
        start += count
    return found


def picked(values: list[Any], index: float) -> Any:
    return values[int(index)] if 0 <= int(index) < len(values) else 0.0


def summed(values: list[float]) -> list[float]:
    return list(accumulate(values[:-1], initial=0.0)) if values else []


KNOWN |= {"parted": parted, "picked": picked, "summed": summed}


class Loop:
    """The plain loop of a category."""

    def __init__(self, batch: Batch):
        self.wanted = list(batch.plan.outputs)
        self.resolve = Writer(batch.program, self.wanted).resolve

    def drawn(self, batch: Batch) -> list[list[list[float]]]:
        """What was drawn for each object: per draw its values in the rows of its table."""
        found: list[list[list[float]]] = [[] for _ in range(len(batch))]
        for number, draw in enumerate(batch.program.draws):
            owner = batch.owner(draw.column.scope)
            edges = np.searchsorted(owner, np.arange(len(batch) + 1)).tolist()
            values = batch.state.values[number].tolist()
            for k, own in enumerate(found):
                own.append(values[edges[k] : edges[k + 1]])
        return found

    def verify(self, batch: Batch, drawn: list[list[list[float]]]) -> float:
        """The largest difference from the columns; AssertionError where one is more than the last bits can make."""
        found, worst = [self.resolve(own) for own in drawn], 0.0
        for place, (expr, scope) in enumerate(self.wanted):
            (column,) = batch.read([expr], scope)
            size = np.bincount(batch.owner(scope), minlength=len(batch)).tolist()
            mine: list[Any] = []
            for own, count in zip(found, size, strict=True):
                value = own[place]
                mine += value if isinstance(value, list) else [value] * count
            with np.errstate(invalid="ignore"):  # the least of no elements, which is endless in both
                off = np.abs(np.array(mine, dtype=np.float64) - column.astype(np.float64))
            off = np.where(
                np.isnan(np.array(mine, dtype=np.float64)) == np.isnan(column.astype(np.float64)),
                np.nan_to_num(off),
                np.inf,
            )
            worst = max(worst, float(off.max(initial=0.0)))
            assert worst <= CLOSE, f"{expr} in {scope.name} is {worst} off"
        return worst


def clock(do: Callable[[], Any]) -> float:
    begun = time.process_time()
    do()
    return time.process_time() - begun


def measure(category: str, count: int, few: int, rounds: int) -> dict[str, float]:
    sampler = Session.of(category).sampler
    batch = sampler.batch(np.arange(few), 7)
    loop = Loop(batch)
    drawn = loop.drawn(batch)
    worst = loop.verify(batch, drawn)
    spent: dict[str, list[float]] = {"columns": [], "plain": [], "rows": []}
    for _ in range(rounds):
        spent["columns"].append(clock(lambda: sampler.batch(np.arange(count), 7)) / count)
        spent["plain"].append(clock(lambda: [loop.resolve(own) for own in drawn]) / few)
        spent["rows"].append(clock(lambda: [sampler.batch(np.arange(k, k + 1), 7) for k in range(8)]) / 8)
    least = {name: 1e6 * min(values) for name, values in spent.items()}
    return least | {
        "plain / columns": least["plain"] / least["columns"],
        "rows / columns": least["rows"] / least["columns"],
        "values": len(loop.wanted),
        "off": worst,
    }


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("categories", nargs="*")
    options.add_argument("-n", type=int, default=1024, help="objects as columns")
    options.add_argument("--few", type=int, default=64, help="objects one by one")
    options.add_argument("--rounds", type=int, default=5)
    options.add_argument("-o", type=Path, help="a file for all figures, JSON")
    given = options.parse_args()
    found: dict[str, dict[str, float]] = {}
    print("| category | values | columns | plain floats | one-row batches | plain / columns | rows / columns |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for category in given.categories or categories():
        try:
            row = found[category] = measure(category, given.n, given.few, given.rounds)
        except NotPlain as left:
            print(f"| {category} | has no plain loop: {left} |", flush=True)
            continue
        figures = [
            f"{row['values']:,}",
            *(f"{row[k]:,.0f}" for k in ("columns", "plain", "rows")),
            *(f"{row[k]:.1f}" for k in ("plain / columns", "rows / columns")),
        ]
        print(f"| {category} | {' | '.join(figures)} |", flush=True)
    if found:
        print(f"\nmedian of plain / columns: {median(row['plain / columns'] for row in found.values()):.1f}")
    if given.o:
        given.o.write_text(json.dumps({"objects": given.n, "few": given.few, "categories": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()

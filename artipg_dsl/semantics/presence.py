"""Whether what a body declares under a guard is there for those who name it from outside: the guards, seen from there."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from ..source import Span
from ..syntax import ast
from ..syntax.walk import walk
from .fold import constant
from .guards import OPERATORS, TRUE, VERSUS, And, Atom, Compare, Condition, Not, Or, conjunction, consistent, domains
from .scope import BodyScope, Entry
from .symbols import Symbol
from .types import BOOL, ChoiceType, ElementType, PartType

if TYPE_CHECKING:
    from .checker import Checker

Read = Callable[[Atom | Compare], Condition]


def _read_as(condition: Condition, read: Read) -> Condition:
    """A condition with every fact in it replaced."""
    match condition:
        case Atom() | Compare():
            return read(condition)
        case And(terms=terms):
            return conjunction(_read_as(t, read) for t in terms)
        case Or(terms=terms):
            return Or(tuple(_read_as(t, read) for t in terms))
        case Not(term=term):
            return Not(_read_as(term, read))
    raise TypeError(condition)


def renamed(condition: Condition, homes: Iterable[tuple[str, str]]) -> Condition:
    """A condition of the inside of bodies, given by (path inside, path of the instance), as it is named from outside."""
    pairs = sorted(homes, key=lambda pair: -len(pair[0]))

    def own(piece: str) -> str:
        for inside, outside in pairs:
            if piece.startswith(inside) and piece[len(inside) : len(inside) + 1] in (".", ":", "#"):
                return outside + piece[len(inside) :].split("~")[0]
        return piece

    def read(fact: Atom | Compare) -> Condition:
        key = "|".join(dict.fromkeys(own(piece) for piece in fact.key.split("|")))
        if isinstance(fact, Atom):
            return Atom(key, fact.allowed, fact.domain)
        return Compare(key, fact.op, fact.value, fact.low, fact.high)

    return _read_as(condition, read)


def declared(ck: Checker, entries: Iterable[Entry]) -> Condition:
    """What holds wherever one of the declarations of a name exists."""
    conditions = tuple(ck.entry_condition(e) for e in entries)
    if TRUE in conditions or not conditions:
        return TRUE
    return conditions[0] if len(conditions) == 1 else Or(conditions)


# ---------------------------------------------------------------- what arguments say


def given(ck: Checker, entry: Entry, kind: PartType) -> Condition:
    """What the arguments of a part say of the choices, switches and counts of its templates."""
    node = entry.node
    assert isinstance(node, ast.PartDecl)
    facts: list[Condition] = []
    named = [a.name for a in node.alternatives]
    for alternative in node.alternatives:
        symbol = entry.scope.owner.module.find(alternative.name) if alternative.name is not None else None
        if symbol is None or symbol.kind != "template" or named.count(alternative.name) > 1:
            continue
        said = told(ck, entry.scope, entry.key, symbol, (*node.arguments, *alternative.arguments))
        if said and len(kind.domain) == 1:
            facts += said
        elif said:
            chosen = frozenset(v for v in kind.domain if v is not None and v.symbol is symbol)
            facts += [Or((Not(Atom(entry.key, chosen, kind.domain)), fact)) for fact in said]
    return conjunction(facts)


def told(ck: Checker, scope: BodyScope, key: str, symbol: Symbol, arguments: Iterable[ast.Argument]) -> list[Condition]:
    """What arguments, written in ``scope``, say of the choices, switches and counts of a template that is known as ``key``."""
    return [
        fact
        for argument in arguments
        if argument.name is not None
        for target in ck.scope_of(symbol).table.get(argument.name, ())
        if (fact := _equal(ck, scope, f"{key}.{argument.name}", target, argument.value)) is not None
    ]


def _equal(ck: Checker, scope: BodyScope, key: str, target: Entry, value: ast.Expr) -> Condition | None:
    """That a discrete parameter has the value that is handed in."""
    if isinstance(target.node, ast.CountDecl):
        number = constant(value, scope.owner.module)
        return None if number is None else Compare(key, "==", int(number))
    kind = ck.entry_type(target)
    values: tuple[Any, ...] = kind.values if isinstance(kind, ChoiceType) else (True, False) if kind == BOOL else ()
    if not values or not isinstance(value, ast.NameExpr):
        return None
    outer = scope.find(value.name)
    if outer:
        pairs = (And((Atom(key, frozenset((v,)), values), Atom(outer[0].key, frozenset((v,)), values))) for v in values)
        return Or(tuple(pairs))
    word = {"true": True, "false": False}.get(value.name, value.name)
    return Atom(key, frozenset((word,)), values) if word in values else None


def relevant(wanted: Condition, facts: Condition) -> Condition:
    """Those of the facts that have to do with what is wanted: questions about guards try all assignments."""
    known = set(domains((wanted,)))
    left = list(facts.terms if isinstance(facts, And) else (facts,))
    taken: list[Condition] = []
    while more := [fact for fact in left if known & set(domains((fact,)))]:
        taken += more
        left = [fact for fact in left if fact not in more]
        known.update(key for fact in more for key in domains((fact,)))
    return conjunction(taken)


def excludes(facts: Condition, wanted: Condition) -> bool:
    """Whether what can hold by itself never does where the facts are given."""
    known = relevant(wanted, facts)
    return consistent(wanted) and consistent(known) and not consistent(known, wanted)


# ---------------------------------------------------------------- elements of repeats


def of_element(element: ElementType, condition: Condition) -> Condition:
    """What is known in the body of a repeat, as it is for the element that is named."""
    chain = [element]
    while chain[-1].outer is not None:
        chain.append(chain[-1].outer)
    homes = [(_body(e).path, e.key) for e in chain if e.key != e.entry.key]
    condition = renamed(condition, [*homes, *([chain[-1].home] if chain[-1].home is not None else [])])
    return _read_as(condition, lambda fact: _known(fact, chain))


def _body(element: ElementType) -> BodyScope:
    return element.entry.scope.inner[id(element.entry.node)]


def _known(fact: Atom | Compare, chain: list[ElementType]) -> Condition:
    """A fact about the rank of an element where that is known: ``e[0]``, ``e[last]``, ``previous``."""
    for element in chain if isinstance(fact, Compare) else ():
        assert isinstance(fact, Compare)
        rank: int | None = None
        if fact.key == f"{element.key}#rank":
            if element.shift:
                own, more = _body(element).rank_key, element.shift
                return Compare(own, fact.op, fact.value + more, fact.low + more, fact.high)
            rank = _rank(element)
        elif fact.key == f"{element.key}:{_at_the_end(element)}":
            rank = 0
        if rank is not None:
            return TRUE if OPERATORS[fact.op](rank, fact.value) else Not(TRUE)
    return fact


def _is_last(element: ElementType) -> bool:
    return isinstance(element.index, ast.NameExpr) and element.index.name == "last"


def _rank(element: ElementType) -> int | None:
    """The rank of an element where it is written as a number."""
    count = element.entry.node.count if isinstance(element.entry.node, ast.RepeatStmt) else None
    node = count if _is_last(element) else element.index
    number = None if node is None else constant(node, element.entry.scope.owner.module)
    return None if number is None else int(number) - _is_last(element)


def _at_the_end(element: ElementType) -> str | None:
    """How guards call the difference between the rank and that of the last element (see ``conditions``)."""
    node = element.entry.node
    if not _is_last(element) or not isinstance(node, ast.RepeatStmt) or node.count is None or node.index is None:
        return None
    return VERSUS.join(sorted((node.index, f"{node.count.span.words} - 1")))


# ---------------------------------------------------------------- in words


def optional(name: str) -> tuple[str, str]:
    """Message and hint for a part that may be absent."""
    return f"`{name.rsplit('.', 1)[-1]}` is optional and may be absent", f"put this inside `when {name} {{ }}`"


def guarded(entry: Entry, at: Span, path: str = "") -> tuple[str, str]:
    """Message and hint for what is declared under a guard; ``path``: what it is named by from outside."""
    where = ""
    if entry.guards:
        guard = entry.guards[-1]
        place = f"line {entry.span.line}"
        if entry.span.source.name != at.source.name:
            place += f" of {entry.span.source.name.rsplit('/', 1)[-1]}"
        where = f": it is declared in {place} {'under' if guard.truth else 'in the `else` of'} `when {guard.test.span.words}`"
    name = f"{path}.{entry.name}" if path else entry.name
    hint = "put this inside the same `when`"
    if path:
        test = outside(entry, path)
        every = f"declare `{entry.name}` in every branch of the `when`"
        hint = every if test is None else f"put this inside `when {test} {{ }}`, or {every}"
    return f"`{name}` only exists under a guard{where}", hint


def outside(entry: Entry, path: str) -> str | None:
    """The guards of a declaration as they are written outside, where ``path`` names the instance; None where they cannot be."""
    tests: list[str] = []
    for guard in entry.guards:
        start, found = guard.test.span.start, guard.test.span.text
        for node in sorted(walk(guard.test), key=lambda n: -n.span.start):
            declared_there = guard.scope.find(node.name) if isinstance(node, ast.NameExpr) else []
            if declared_there:
                if declared_there[0].private or guard.scope.repeat is not None:
                    return None
                at = node.span.start - start
                found = f"{found[:at]}{path}.{found[at:]}"
        found = " ".join(found.split())
        tests.append(
            found if guard.truth and len(entry.guards) == 1 else f"({found})" if guard.truth else f"not ({found})"
        )
    return " and ".join(tests)

"""Classes of data behave as those of the standard library."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
from typing import Any

import pytest

from artipg_dsl.records import dataclass

WAYS: list[dict[str, Any]] = [
    {},
    {"frozen": True},
    {"slots": True},
    {"frozen": True, "slots": True},
    {"eq": False, "slots": True},
    {"frozen": True, "eq": False},
    {"frozen": True, "slots": True, "kw_only": True},
    {"repr": False, "slots": True},
]


class Plain:
    """What both decorators are put on."""

    a: int
    b: list[int] = dataclasses.field(default_factory=list)
    c: str = "c"
    d: int = dataclasses.field(default=4, compare=False, repr=False)
    e: tuple[int, ...] = dataclasses.field(init=False, default=(1, 2))


def both(options: dict[str, Any]) -> tuple[Any, Any]:
    body = {name: value for name, value in vars(Plain).items() if name not in ("__dict__", "__weakref__")}
    ours, theirs = (type("Thing", (), body | {"__module__": __name__, "__qualname__": "Thing"}) for _ in range(2))
    return dataclass(**options)(ours), dataclasses.dataclass(**options)(theirs)


@pytest.mark.parametrize("options", WAYS, ids=str)
def test_it_does_what_the_standard_one_does(options: dict[str, Any]) -> None:
    ours, theirs = both(options)
    assert (
        str(inspect.signature(ours)) == str(inspect.signature(theirs)) and ours.__match_args__ == theirs.__match_args__
    )
    assert [f.name for f in dataclasses.fields(ours)] == [f.name for f in dataclasses.fields(theirs)]
    assert hasattr(ours, "__slots__") == hasattr(theirs, "__slots__")
    assert (ours.__hash__ is None) == (theirs.__hash__ is None)
    made = []
    for kind in (ours, theirs):
        one, same, other = kind(a=1), kind(a=1), kind(a=2, c="x", d=7)
        facts = [
            one == same,
            one == other,
            one == kind(a=1, d=9),
            one.b is same.b,
            one.d,
            one.e,
            dataclasses.asdict(other),
        ]
        facts += [dataclasses.asdict(dataclasses.replace(other, a=3)), repr(one) if options.get("repr", True) else None]
        facts += [dataclasses.asdict(copy.copy(other)), dataclasses.asdict(copy.deepcopy(other))]
        for change in (lambda one: setattr(one, "a", 5), lambda one: delattr(one, "c")):
            try:
                change(one)
                facts.append(dataclasses.FrozenInstanceError if options.get("frozen") else getattr(one, "a", None))
            except dataclasses.FrozenInstanceError as error:
                facts.append(str(error))
        with pytest.raises(TypeError) as wrong:
            kind(1, 2, 3, 4, 5, 6)
        facts.append(str(wrong.value).replace(kind.__qualname__, ""))
        with pytest.raises(TypeError) as wrong:
            kind(a=1, unknown=2)
        made.append([*facts, str(wrong.value)])
    assert made[0] == made[1]


def test_hashes_are_of_what_is_compared() -> None:
    @dataclass(frozen=True)
    class Pair:
        one: int
        two: int = dataclasses.field(default=0, compare=False)

    assert hash(Pair(1, 2)) == hash(Pair(1, 3)) and {Pair(1, 2)} == {Pair(1, 5)}
    assert Pair(1) != (1,) and Pair(1) != object()


@dataclass(frozen=True, slots=True)
class Stored:
    """For a pickle, which finds it by name."""

    number: int
    words: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Derived(Stored):
    """With fields of its own."""

    more: float = 0.5

    def __post_init__(self) -> None:
        if self.more < 0:
            raise ValueError(self.more)


def test_it_is_pickled_derived_and_looked_at_after_it_is_made() -> None:
    one = Derived(3, ("a",), more=2.0)
    assert pickle.loads(pickle.dumps(one)) == one and pickle.loads(pickle.dumps(Stored(1))) == Stored(1)
    with pytest.raises(ValueError):
        Derived(3, more=-1.0)
    match one:
        case Derived(number, words):
            assert (number, words) == (3, ("a",))
    assert Derived(3) != Stored(3)


def test_either_decorator_stands_on_the_other() -> None:
    @dataclasses.dataclass(frozen=True, slots=True)
    class Standard(Stored):
        more: int = 1

    @dataclass(frozen=True, slots=True)
    class Ours(Standard):
        most: int = 2

    assert dataclasses.astuple(Ours(5)) == (5, (), 1, 2) and Standard(5) == Standard(5)
    for name in ("number", "more", "most"):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(Ours(5), name, 6)
    for kind in (dataclass, dataclasses.dataclass):
        with pytest.raises(TypeError, match="cannot inherit non-frozen dataclass from a frozen one"):
            kind(slots=True)(type("Thawed", (Stored,), {}))


def test_a_method_of_its_own_stays() -> None:
    @dataclass(slots=True)
    class Own:
        value: int

        def __init__(self, value: str):
            self.value = int(value)

        def __repr__(self) -> str:
            return "own"

        def __eq__(self, other: object) -> bool:
            return True

    assert Own("3").value == 3 and repr(Own("3")) == "own" and Own("3") == Own("4")

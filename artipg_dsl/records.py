"""The ``dataclass`` of the standard library, made in a fraction of the time.

The standard decorator compiles four to six functions for each class; with the hundreds of classes of a compiler that is a tenth of the start
of ``apgc``. Here the methods are closures, and ``__init__`` alone is compiled, once a class is first called.
``fields``, ``replace``, ``asdict``, ``match``, ``copy``, pickles and signatures work as ever.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from operator import attrgetter
from reprlib import recursive_repr
from types import CodeType, FunctionType, MemberDescriptorType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(*, frozen=False, slots=False, eq=True, repr=True, kw_only=False):
        """As the standard decorator does, for those of its arguments that are taken."""

        def made(plain: type) -> type:
            plain.__doc__ = plain.__doc__ or plain.__name__  # else the standard library asks for the signature
            with _thawed(plain, frozen):
                cls = dataclasses.dataclass(init=False, repr=False, eq=False, slots=slots, kw_only=kw_only)(plain)
            cls.__dataclass_params__.frozen = frozen
            own, names = cls.__dict__, [f.name for f in dataclasses.fields(cls)]
            if "__init__" not in own:
                cls.__init__ = _Init(cls, frozen)
            if repr and "__repr__" not in own:
                cls.__repr__ = _repr
            if eq:
                _compare(cls, frozen)
            if frozen:
                cls.__setattr__, cls.__delattr__ = _guards(cls, frozenset(names))
                if slots and "__getstate__" not in own:
                    cls.__getstate__, cls.__setstate__ = _states(names)
            return cls

        return made


@contextmanager
def _thawed(cls: type, frozen: bool) -> Iterator[None]:
    """What ``cls`` stands on passes for classes that are not frozen, which the standard library would compile two functions for. Raises
    TypeError where one is frozen and the other is not."""
    below = [vars(base)["__dataclass_params__"] for base in cls.__mro__[1:] if "__dataclass_params__" in vars(base)]
    known = [params.frozen for params in below]
    if any(was != frozen for was in known):
        kinds = ("non-frozen", "frozen") if frozen else ("frozen", "non-frozen")
        raise TypeError(f"cannot inherit {kinds[1]} dataclass from a {kinds[0]} one")
    try:
        for params in below:
            params.frozen = False
        yield
    finally:
        for params, was in zip(below, known, strict=True):
            params.frozen = was


class _Init:
    """``__init__`` until it is asked for: then it is compiled, and takes this one's place."""

    def __init__(self, cls: type, frozen: bool):
        self.cls, self.frozen = cls, frozen

    def __get__(self, instance: Any, owner: type) -> Callable[..., None]:
        if isinstance(self.cls.__dict__.get("__init__"), _Init):
            type.__setattr__(self.cls, "__init__", _written(self.cls, self.frozen))
        found = self.cls.__dict__["__init__"]
        return found if instance is None else found.__get__(instance, owner)


class _Absent:
    """Where an argument is left out that a factory makes."""

    def __repr__(self) -> str:
        return "<factory>"


_ABSENT = _Absent()


def _written(cls: Any, frozen: bool) -> Callable[..., None]:
    """The ``__init__`` of a class: an argument for each of its fields that takes one."""
    fields = dataclasses.fields(cls)
    slots = frozen and all(isinstance(getattr(cls, f.name, None), MemberDescriptorType) for f in fields)
    known: dict[str, Any] = {"_set": object.__setattr__, "_absent": _ABSENT}
    shape, names = [], {}
    plain: list[Any] = []
    named: dict[str, Any] = {}
    for number, field in enumerate(fields):
        made = field.default_factory is not dataclasses.MISSING
        default = field.default_factory if made else field.default
        given = default is not dataclasses.MISSING
        known |= {f"default{number}": default, f"name{number}": field.name}
        if slots:
            known[f"set{number}"] = getattr(cls, field.name).__set__
        names[f"a{number}"] = field.name
        shape.append((field.init, made, given or field.init, field.kw_only))
        value = _ABSENT if made else default
        if field.init and field.kw_only:
            named |= {field.name: value} if given else {}
        elif field.init and given:
            plain.append(value)
        elif field.init and plain:
            raise TypeError(f"non-default argument {field.name!r} follows default argument")
    code = _body(tuple(shape), frozen, slots, hasattr(cls, "__post_init__"))
    variables, read = (tuple([names.get(name, name) for name in of]) for of in (code.co_varnames, code.co_names))
    code = code.replace(co_varnames=variables, co_names=read)
    written = FunctionType(code, known, "__init__", tuple(plain))
    written.__kwdefaults__ = named
    written.__annotations__ = {f.name: f.type for f in fields if f.init} | {"return": None}
    written.__qualname__, written.__module__ = f"{cls.__qualname__}.__init__", cls.__module__
    return written


@cache
def _body(shape: tuple[tuple[bool, bool, bool, bool], ...], frozen: bool, slots: bool, post: bool) -> CodeType:
    """The code of an ``__init__`` whose fields are called ``a0``, ``a1``, ...; of each, whether it is an argument, has a default, by a
    factory, and is taken by its name alone. Many classes share one: to compile it takes ten times as long as to change its names."""
    plain, named, body = ["self"], list[str](), list[str]()
    for number, (init, made, given, kw_only) in enumerate(shape):
        name = value = f"a{number}"
        if init:
            (named if kw_only else plain).append(name)
        elif not given:
            continue
        if made:
            value = f"default{number}() if {name} is _absent else {name}" if init else f"default{number}()"
        elif not init:
            value = f"default{number}"
        if slots:
            body.append(f"set{number}(self, {value})")
        else:
            body.append(f"_set(self, name{number}, {value})" if frozen else f"self.{name} = {value}")
    if post:
        body.append("self.__post_init__()")
    arguments = ", ".join([*plain, *(["*", *named] if named else [])])
    space: dict[str, Any] = {}
    exec(f"def __init__({arguments}):\n " + "\n ".join(body or ["pass"]), space)
    code: CodeType = space["__init__"].__code__
    return code


@recursive_repr()
def _repr(self: Any) -> str:
    said = (f"{f.name}={getattr(self, f.name)!r}" for f in dataclasses.fields(self) if f.repr)
    return f"{type(self).__qualname__}({', '.join(said)})"


def _compare(cls: Any, frozen: bool) -> None:
    """``__eq__`` and ``__hash__`` of the values of its fields, unless the class has its own."""
    names = [f.name for f in dataclasses.fields(cls) if f.compare]
    values: Callable[[Any], tuple[Any, ...]]
    if len(names) > 1:
        values = attrgetter(*names)
    else:
        values = lambda self: tuple(getattr(self, name) for name in names)  # noqa: E731

    def __eq__(self: Any, other: object) -> Any:
        return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

    def __hash__(self: Any) -> int:
        return hash(values(self))

    own = cls.__dict__
    explicit = own.get("__hash__") is not None or "__hash__" in own and "__eq__" not in own
    if "__eq__" not in own:
        cls.__eq__ = __eq__
    if not explicit:
        cls.__hash__ = __hash__ if frozen else None


def _guards(cls: Any, names: frozenset[str]) -> tuple[Callable[..., None], Callable[..., None]]:
    """``__setattr__`` and ``__delattr__`` of a frozen class; a plain class that stands on it may have attributes of its own."""

    def __setattr__(self: Any, name: str, value: Any) -> None:
        if type(self) is cls or name in names:
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        super(cls, self).__setattr__(name, value)

    def __delattr__(self: Any, name: str) -> None:
        if type(self) is cls or name in names:
            raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
        super(cls, self).__delattr__(name)

    return __setattr__, __delattr__


def _states(names: list[str]) -> tuple[Callable[..., list[Any]], Callable[..., None]]:
    """``__getstate__`` and ``__setstate__`` of a frozen class with slots, which pickles could not fill otherwise."""

    def __getstate__(self: Any) -> list[Any]:
        return [getattr(self, name) for name in names]

    def __setstate__(self: Any, state: list[Any]) -> None:
        for name, value in zip(names, state, strict=True):
            object.__setattr__(self, name, value)

    return __getstate__, __setstate__

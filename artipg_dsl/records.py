"""The ``dataclass`` of the standard library, made in a fraction of the time.

The standard decorator compiles four to six functions for each class, and asks of each annotation in five ways whether it is a field; with
the hundreds of classes of a compiler that is a tenth of the start of ``apgc``. Here the methods are closures, and ``__init__`` alone is
compiled, once a class has been called a few times. ``fields``, ``replace``, ``asdict``, ``match``, ``copy``, pickles and signatures work
as ever.
"""

from __future__ import annotations

import dataclasses
import inspect
import sys
from collections.abc import Callable
from functools import cache, cached_property
from operator import attrgetter
from reprlib import recursive_repr
from types import CodeType, FunctionType, MemberDescriptorType, MethodType, SimpleNamespace
from typing import TYPE_CHECKING, Any

_FEW = 5  # calls of a class that compiling its ``__init__`` takes longer than
_FIELD = vars(dataclasses)["_FIELD"]  # what marks a field, to the functions of the standard library

# to a Python that it was never tried on, this code yields: slower, and right
if TYPE_CHECKING or sys.version_info >= (3, 14):
    from dataclasses import dataclass as dataclass
else:

    def dataclass(*, frozen=False, slots=False, eq=True, repr=True, kw_only=False):
        """As the standard decorator does, for those of its arguments that are taken."""

        def made(cls: type) -> type:
            _stand_alike(cls, frozen)
            fields = _collect(cls, kw_only)
            names = list(fields)
            if slots:
                cls = _slotted(cls, names)
            cls.__dataclass_fields__ = fields
            cls.__dataclass_params__ = SimpleNamespace(
                init=True, repr=repr, eq=eq, order=False, unsafe_hash=False, frozen=frozen
            )
            own = cls.__dict__
            cls.__doc__ = cls.__doc__ or cls.__name__
            if "__match_args__" not in own:
                cls.__match_args__ = tuple([f.name for f in fields.values() if f.init and not f.kw_only])
            if "__init__" not in own:
                cls.__init__ = _Init(cls, frozen)
            if "__replace__" not in own:
                cls.__replace__ = _replaced
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


def _stand_alike(cls: type, frozen: bool) -> None:
    """Refuse a class that stands on a frozen one and is not frozen, or the other way round, as the standard library does."""
    for base in cls.__mro__[1:]:
        params = base.__dict__.get("__dataclass_params__")
        if params is not None and params.frozen != frozen:
            kinds = ("non-frozen", "frozen") if frozen else ("frozen", "non-frozen")
            raise TypeError(f"cannot inherit {kinds[1]} dataclass from a {kinds[0]} one")


def _collect(cls: Any, kw_only: bool) -> dict[str, dataclasses.Field[Any]]:
    """The fields of a class, those of what it stands on first; their defaults become attributes. Annotations are texts, and each is that
    of a field: ``ClassVar``, ``InitVar`` and ``KW_ONLY`` are not taken."""
    found: dict[str, Any] = {}
    for base in cls.__mro__[:0:-1]:
        found |= base.__dict__.get("__dataclass_fields__", {})
    for name, kind in inspect.get_annotations(cls).items():
        if not isinstance(kind, str) or kind.startswith(("ClassVar", "InitVar", "KW_ONLY")):
            raise TypeError(f"{cls.__qualname__}.{name}: {kind} is not taken as the annotation of a field")
        default = cls.__dict__.get(name, dataclasses.MISSING)
        field: Any = default
        if not isinstance(default, dataclasses.Field):
            field = (
                dataclasses.field() if isinstance(default, MemberDescriptorType) else dataclasses.field(default=default)
            )
        elif default.default is dataclasses.MISSING:
            delattr(cls, name)
        else:
            setattr(cls, name, default.default)
        if field.default.__class__.__hash__ is None:
            raise ValueError(
                f"mutable default {type(field.default)} for field {name} is not allowed: use default_factory"
            )
        field.name, field.type, field._field_type = name, kind, _FIELD
        if field.kw_only is dataclasses.MISSING:
            field.kw_only = kw_only
        found[name] = field
    return found


def _slotted(plain: type, names: list[str]) -> type:
    """The class anew, with a slot for each of its fields that nothing which it stands on has one for."""
    held = {slot for base in plain.__mro__[1:] for slot in base.__dict__.get("__slots__", ())}
    space = dict(plain.__dict__)
    for name in (*names, "__dict__", "__weakref__"):
        space.pop(name, None)
    space["__slots__"] = tuple([name for name in names if name not in held])
    cls = type(plain)(plain.__name__, plain.__bases__, space)
    cls.__qualname__ = plain.__qualname__
    return cls


class _Init:
    """``__init__`` until it has been asked for a few times: then it is compiled, and takes this one's place. Who asks the class for it,
    as for its signature, gets the compiled one."""

    def __init__(self, cls: type, frozen: bool):
        self.cls, self.frozen, self.calls = cls, frozen, 0

    def __get__(self, instance: Any, owner: type) -> Callable[..., None]:
        self.calls += 1
        # from Python 3.13 on, who wants a signature asks with the class itself as the instance
        if self.calls <= _FEW and isinstance(instance, self.cls):
            return MethodType(self.fill, instance)
        found = self.compiled
        return found if instance is None else found.__get__(instance, owner)

    @cached_property
    def compiled(self) -> Any:
        made = _written(self.cls, self.frozen)
        if self.cls.__dict__.get("__init__") is self:
            type.__setattr__(self.cls, "__init__", made)
        return made

    @cached_property
    def fields(self) -> tuple[dataclasses.Field[Any], ...]:
        return dataclasses.fields(self.cls)

    def fill(self, made: Any, /, *given: Any, **named: Any) -> None:
        """As the compiled one does, which is asked wherever it would complain."""
        plain = [f.name for f in self.fields if f.init and not f.kw_only]
        values = dict(zip(plain, given, strict=False))
        if len(given) > len(plain) or not values.keys().isdisjoint(named):
            return self.compiled(made, *given, **named)
        values |= named
        filled = {}
        for f in self.fields:
            if f.init and f.name in values:
                filled[f.name] = values.pop(f.name)
            elif f.default is not dataclasses.MISSING:
                filled[f.name] = f.default
            elif f.default_factory is not dataclasses.MISSING:
                filled[f.name] = f.default_factory()
            elif f.init:
                return self.compiled(made, *given, **named)
        if values:
            return self.compiled(made, *given, **named)
        put = object.__setattr__ if self.frozen else setattr
        for name, value in filled.items():
            put(made, name, value)
        if hasattr(made, "__post_init__"):
            made.__post_init__()
        return None


def _replaced(self: Any, /, **changes: Any) -> Any:
    return dataclasses.replace(self, **changes)


class _Absent:
    """Where an argument is left out that a factory makes."""

    def __repr__(self) -> str:
        return "<factory>"


_ABSENT = _Absent()


def _written(cls: Any, frozen: bool) -> Callable[..., None]:
    """The ``__init__`` of a class: an argument for each of its fields that takes one."""
    fields = sorted(dataclasses.fields(cls), key=lambda f: f.kw_only is True)  # as arguments stand
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
        shape.append((field.init, made, given or field.init))
        value = _ABSENT if made else default
        if field.init and field.kw_only:
            named |= {field.name: value} if given else {}
        elif field.init and given:
            plain.append(value)
        elif field.init and plain:
            raise TypeError(f"non-default argument {field.name!r} follows default argument")
    code = _body(tuple(shape), frozen, slots, hasattr(cls, "__post_init__"))
    variables, read = (tuple([names.get(name, name) for name in of]) for of in (code.co_varnames, code.co_names))
    by_name = sum(f.init and f.kw_only is True for f in fields)
    code = code.replace(
        co_varnames=variables, co_names=read, co_argcount=code.co_argcount - by_name, co_kwonlyargcount=by_name
    )
    written = FunctionType(code, known, "__init__", tuple(plain))
    written.__kwdefaults__ = named
    written.__annotations__ = {f.name: f.type for f in fields if f.init} | {"return": None}
    written.__qualname__, written.__module__ = f"{cls.__qualname__}.__init__", cls.__module__
    return written


@cache
def _body(shape: tuple[tuple[bool, bool, bool], ...], frozen: bool, slots: bool, post: bool) -> CodeType:
    """The code of an ``__init__`` whose fields are called ``a0``, ``a1``, ...; of each, whether it is an argument, has a default that a
    factory makes, and has one at all. Many classes share one: to compile it takes ten times as long as to change its names."""
    arguments, body = ["self"], list[str]()
    for number, (init, made, given) in enumerate(shape):
        name = value = f"a{number}"
        if init:
            arguments.append(name)
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
    space: dict[str, Any] = {}
    exec(f"def __init__({', '.join(arguments)}):\n " + "\n ".join(body or ["pass"]), space)
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
        if other.__class__ is not self.__class__:
            return NotImplemented
        return other is self or values(self) == values(other)

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

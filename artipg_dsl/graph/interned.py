"""Objects by what they are made of, as long as anyone holds them: a WeakValueDictionary in half its time, as programs have 100,000 nodes."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, TypeVar
from weakref import ref

T = TypeVar("T")


class _Held(ref[T]):
    __slots__ = ("key",)
    key: Hashable


class Interned(Generic[T]):
    def __init__(self) -> None:
        self._held: dict[Hashable, _Held[T]] = {}

    def find(self, key: Hashable) -> T | None:
        held = self._held.get(key)
        return None if held is None else held()

    def keep(self, key: Hashable, found: T) -> None:
        held = self._held[key] = _Held(found, self._forget)
        held.key = key

    def _forget(self, held: _Held[T]) -> None:
        if self._held.get(held.key) is held:  # not one that was made since
            del self._held[held.key]

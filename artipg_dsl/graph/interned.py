"""Objects by what they are made of, as long as anyone holds them: a WeakValueDictionary in half its time, as programs have 100,000 nodes.

No code runs when an object goes: Python drops what is raised in there, an interrupt (Ctrl-C) among it. The entries of those that are
gone are swept out once there are twice as many entries as the last sweep left.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, TypeVar
from weakref import ref

T = TypeVar("T")
_FEWEST = 50_000  # entries that are worth a sweep


class Interned(Generic[T]):
    def __init__(self) -> None:
        self._held: dict[Hashable, ref[T]] = {}
        self._most = _FEWEST

    def find(self, key: Hashable) -> T | None:
        held = self._held.get(key)
        return None if held is None else held()

    def keep(self, key: Hashable, found: T) -> None:
        if len(self._held) >= self._most:
            self._sweep()
        self._held[key] = ref(found)

    def _sweep(self) -> None:
        """The last entries first: a key holds the arguments of its object, which were made before, and lets go of them here."""
        entries = list(self._held.items())
        while entries:
            key, held = entries.pop()
            if held() is None and self._held.get(key) is held:  # not one that was made since
                del self._held[key]
        self._most = max(_FEWEST, 2 * len(self._held))

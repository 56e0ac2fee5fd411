"""How points are to be taken from surfaces: how many of what, from which surface, how spread."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import UsageError
from ..records import dataclass

SURFACES = {
    "boundary": "of the union of all primitives, even where only an open door would show it",
    "outside": "the part of it that is visible from outside, with all joints at 0",
}
SPREADS = {"random": "each point independently", "blue": "points keep their distance from one another"}
POOLS = {
    "object": "the object",
    "semantic": "each class of parts",
    "instance": "each part instance",
    "link": "each link",
    "primitive": "each primitive",
}
MOST = 1_000_000


@dataclass(frozen=True, slots=True)
class Sampling:
    """``count`` points per ``per`` (of ``POOLS``) on the ``surface`` (of ``SURFACES``), ``spread`` as of ``SPREADS``.

    With ``balance`` (of ``POOLS``, but the object) the points of an object are shared out evenly over its classes,
    instances, links or primitives, or by their ``weights``, pairs of a name and a number (1 where none is given).
    Raises UsageError.
    """

    count: int = 2048
    surface: str = "boundary"
    spread: str = "random"
    per: str = "object"
    balance: str = ""
    weights: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        if isinstance(self.count, bool) or not isinstance(self.count, int | np.integer):
            raise UsageError(f"the number of points is {self.count!r}: a whole number is needed", "for example 2048")
        if not 1 <= self.count <= MOST:
            raise UsageError(f"the number of points is {self.count}", f"give a number from 1 to {MOST}")
        shared = [name for name in POOLS if name != "object"]
        for name, known in (("surface", SURFACES), ("spread", SPREADS), ("per", POOLS), ("balance", ["", *shared])):
            value = getattr(self, name)
            if value not in known:
                raise UsageError(f"{name} is {value!r}", f"it may be {', '.join(filter(None, known))}")
        if self.balance and self.per != "object":
            raise UsageError(
                f"points are asked for per {self.per} and balanced over each {self.balance}",
                "`per` gives each its own number of points, `balance` shares out those of an object: choose one",
            )
        if self.weights and not self.balance:
            raise UsageError(
                "weights of points are given without `balance`",
                f'balance may be {", ".join(shared)}: --balance semantic, in Python balance="semantic"',
            )
        for name, weight in self.weights:
            if not 0 < weight < np.inf:
                raise UsageError(f"the weight of {name} is {weight}", "give a number above 0")

    @property
    def uneven(self) -> bool:
        """Whether points lie denser in some places than in others."""
        return bool(self.balance) or self.per != "object"

    def plain(self) -> dict[str, Any]:
        found = {"points": int(self.count), "surface": self.surface, "spread": self.spread, "per": self.per}
        if self.balance:
            found["balance"] = self.balance
        return found | ({"weights": dict(self.weights)} if self.weights else {})


def read_weights(weights: str | Mapping[str, float] | None) -> tuple[tuple[str, float], ...]:
    """``"handle=3,knob=0.5"``, or the same as a dictionary. Raises UsageError."""
    if weights is None or isinstance(weights, str):
        pieces = [piece.partition("=") for piece in (weights or "").split(",") if piece.strip()]
        found: list[tuple[str, Any]] = [(name.strip(), value.strip()) for name, _, value in pieces]
    elif isinstance(weights, Mapping):
        found = list(weights.items())
    else:
        raise UsageError(f"weights is {weights!r}", 'it maps names to numbers: {"handle": 3}')
    made = []
    for name, value in found:
        try:
            made.append((str(name), float(value)))
        except (TypeError, ValueError):
            raise UsageError(f"the weight of {name} is {value!r}: a number is needed", "for example handle=3") from None
    twice = [name for k, (name, _) in enumerate(made) if name in dict(made[:k])]
    if twice:
        raise UsageError(f"{twice[0]} has two weights", "give it one")
    return tuple(sorted(made))

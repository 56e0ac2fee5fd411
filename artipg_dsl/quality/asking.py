"""Objects that are asked for on purpose, with draws that are given values: many questions are evaluated as one batch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from ..graph.program import Program
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import State
from ..runtime.plan import Plan
from ..sampling.known import make_batch


@dataclass(frozen=True, slots=True)
class Question:
    """Values by the index of their draw, and the numbers of the objects that are given them."""

    values: Mapping[int, float]
    numbers: np.ndarray


@dataclass(frozen=True, slots=True)
class Answers:
    """The objects of the questions from ``first`` on; those of question ``first + k`` lie from ``start[k]`` to ``start[k + 1]``."""

    first: int
    start: list[int]
    batch: Batch

    def objects(self) -> Iterator[slice]:
        """The objects of each question."""
        return (slice(*ends) for ends in pairwise(self.start))


def ask(
    program: Program,
    plan: Plan,
    seed: int,
    fixed: Mapping[int, np.ndarray | float],
    questions: Sequence[Question],
    together: int,
) -> Iterator[Answers]:
    """First attempts at the objects of all questions, about ``together`` objects in a batch. ``fixed``: what all are given."""
    first = 0
    while first < len(questions):
        start = [0]
        while first + len(start) <= len(questions) and (len(start) == 1 or start[-1] < together):
            start.append(start[-1] + len(questions[first + len(start) - 1].numbers))
        some = questions[first : first + len(start) - 1]
        asked: dict[int, np.ndarray] = {}
        for k, question in enumerate(some):
            for number, value in question.values.items():
                own = asked.setdefault(number, np.full(start[-1], np.nan))
                own[start[k] : start[k + 1]] = value
        numbers = np.concatenate([question.numbers for question in some])
        state = State(seed, numbers, np.zeros(len(numbers), dtype=np.int64), dict(fixed), asked=asked)
        yield Answers(first, start, make_batch(program, plan, state))
        first += len(some)

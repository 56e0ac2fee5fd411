"""The quality card of a category: every figure over some samples, and the goal that stands beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import cache
from typing import Any

from ..export.strict import Strict
from ..records import dataclass
from ..runtime.batch import Batch
from ..sampling.sample import Sampler
from .coverage import Coverage, measure_coverage
from .dead import (
    Dead,
    draw_further,
    find_dead_alternatives,
    find_dead_grasps,
    find_dead_labels,
    find_dead_parameters,
    find_idle_labels,
)
from .distance import measure_distance
from .duplicates import CLOSE, find_near_duplicates
from .graphs import Graphs, find_graphs
from .sizes import Extent, Real, compare_ratios, compare_sizes, measure_extents
from .variants import Given, Variant, find_variants

_VERSION = 1  # of the JSON form
VALID, DUPLICATE, WITHIN, RATIOS, LINES = 0.99, 0.01, 0.75, 0.8, 200  # the goals
_SHOWN = 12  # graphs that are listed


@dataclass(frozen=True, slots=True)
class Goal:
    """What a figure should be, in words; whether it is."""

    figure: str
    goal: str
    met: bool


@dataclass(frozen=True, slots=True)
class Valid:
    """First attempts that were valid, attempts in all, and what failed in how many, in words with its line."""

    first: int
    attempts: int
    failed: dict[str, int]


@dataclass(frozen=True, slots=True)
class Variety:
    """Distinct kinematic graphs, their perplexity, the mean edit distance of ``pairs`` pairs of objects, joints per object.

    ``kinds`` are the most frequent graphs in words, with how many objects have each.
    """

    distinct: int
    perplexity: float
    distance: float
    pairs: int
    joints_mean: float
    joints_variance: float
    joints_least: int
    joints_most: int
    kinds: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True)
class Card:
    """All figures of a category. ``lines`` of its own text without blank lines and comments; None for compiled programs."""

    category: str
    program: str
    seed: int
    objects: int
    checked: bool
    valid: Valid
    variety: Variety
    duplicates: int
    pairs: Coverage
    sizes: tuple[Extent, ...]
    real: Real | None
    dead_parameters: tuple[Dead, ...]
    dead_alternatives: tuple[Dead, ...]
    dead_labels: tuple[Dead, ...]
    lines: int | None
    meshes: Strict | None = None  # of the first objects, where that was asked for
    ratios: tuple[Extent, ...] = ()
    variants: tuple[Variant, ...] = ()
    prior: str = ""  # by which the objects are drawn, in words

    @property
    def lacking(self) -> tuple[Variant, ...]:
        """Variants that no object shows, or that their settings do not reach."""
        return tuple(v for v in self.variants if not v.objects or v.refused)

    @property
    def goals(self) -> tuple[Goal, ...]:
        """The goals in the order of the figures; one without a number to reach is left out."""
        wanted = None if self.real is None else self.real.graphs
        sized = [e.within for e in self.sizes if e.within is not None]
        found = [Goal("valid", f">= {100 * VALID:.0f}%", self.valid.first >= VALID * self.objects)]
        if wanted is not None:
            found.append(Goal("graphs", f">= {wanted}", self.variety.distinct >= wanted))
        found.append(Goal("duplicates", f"< {100 * DUPLICATE:.0f}%", self.duplicates < DUPLICATE * self.objects))
        found.append(Goal("pairs", "100%", not self.pairs.missed))
        if sized:
            found.append(Goal("sizes", f">= {100 * WITHIN:.0f}% on each axis", min(sized) >= WITHIN))
        if self.ratios:
            least = min(e.within or 0.0 for e in self.ratios)
            found.append(Goal("ratios", f">= {100 * RATIOS:.0f}% of each", least >= RATIOS))
        if self.variants:
            found.append(Goal("variants", "all", not self.lacking))
        found.append(Goal("dead parameters", "none", not self.dead_parameters))
        found.append(Goal("dead alternatives", "none", not self.dead_alternatives))
        found.append(Goal("dead labels", "none", not self.dead_labels))
        if self.meshes is not None:
            found.append(Goal("meshes", f">= {100 * VALID:.0f}%", self.meshes.all >= VALID * self.meshes.objects))
        if self.lines is not None:
            found.append(Goal("lines", f"< {LINES}", self.lines < LINES))
        return tuple(found)

    @property
    def met(self) -> bool:
        return all(goal.met for goal in self.goals)

    def plain(self) -> dict[str, Any]:
        """The card as plain data, as `--json` prints it."""
        variety, pairs = asdict(self.variety), self.pairs
        kinds = [{"graph": text, "objects": count} for text, count in variety.pop("kinds")]
        return {
            "version": _VERSION,
            "category": self.category,
            "program": self.program,
            "seed": self.seed,
            "objects": self.objects,
            "checked": self.checked,
            **({"prior": self.prior} if self.prior else {}),
            "valid": {**asdict(self.valid), "share": self.valid.first / self.objects},
            "graphs": {**variety, "kinds": kinds},
            "duplicates": {"objects": self.duplicates, "share": self.duplicates / self.objects, "within": CLOSE},
            "pairs": {
                "seen": pairs.seen,
                "possible": pairs.possible,
                "share": pairs.share,
                "missed": [asdict(p) for p in pairs.missed],
                "excluded": [asdict(p) for p in pairs.excluded],
            },
            "sizes": {
                "axes": [asdict(e) for e in self.sizes],
                "ratios": [asdict(e) for e in self.ratios],
                "source": self.real.source if self.real is not None else "",
            },
            "variants": {
                "seen": sum(v.objects > 0 for v in self.variants),
                "known": len(self.variants),
                "list": [asdict(v) for v in self.variants],
            },
            "dead": {
                "parameters": [asdict(d) for d in self.dead_parameters],
                "alternatives": [asdict(d) for d in self.dead_alternatives],
                "labels": [asdict(d) for d in self.dead_labels],
            },
            "meshes": None
            if self.meshes is None
            else {**asdict(self.meshes), "share": self.meshes.all / self.meshes.objects},
            "lines": self.lines,
            "goals": [asdict(goal) for goal in self.goals],
            "met": self.met,
        }


STEPS = (
    "sampling",
    "graphs",
    "near-duplicates",
    "pairs",
    "sizes",
    "variants",
    "dead parameters",
    "dead alternatives",
    "dead labels",
)


@dataclass(frozen=True, slots=True)
class Known:
    """What is known beside the objects: how many were ``valid`` at first, whether collisions were looked for (``checked``), the ``prior`` by
    which they were drawn, in words, what the ``meshes`` of some share; ``real`` sizes, the settings of ``variants`` by draws; ``lines`` as in
    the card."""

    valid: Valid
    checked: bool
    prior: str
    meshes: Strict | None
    real: Real | None
    variants: Given
    lines: int | None


def make_card(
    sampler: Sampler, batch: Batch, known: Known, progress: Callable[[str, int, int], None] | None = None
) -> Card:
    """The card of a program over the objects of a batch.

    ``progress(step, done, total)`` is called at the start of each step after the sampling, with 0 of 0, and within the long ones.
    """

    def step(name: str) -> Callable[[int, int], None]:
        def told(done: int, total: int) -> None:
            if progress is not None:
                progress(name, done, total)

        told(0, 0)
        return told

    real = known.real
    step("graphs")
    found = find_graphs(batch)
    variety = _variety(found)
    step("near-duplicates")
    close = int(find_near_duplicates(batch, found.code).sum())
    pairs = measure_coverage(sampler, batch, step("pairs"))
    step("sizes")
    size = measure_extents(batch)
    step("variants")
    variants = find_variants(sampler, batch, known.variants, {} if real is None else real.variants, known.checked)
    further = cache(lambda: draw_further(sampler, batch))
    parameters = tuple(find_dead_parameters(batch, further, step("dead parameters")))
    alternatives = tuple(find_dead_alternatives(sampler, batch, further, step("dead alternatives")))
    step("dead labels")
    return Card(
        category=batch.program.name,
        program=batch.program.hash,
        seed=batch.seed,
        objects=len(batch),
        checked=known.checked,
        valid=known.valid,
        variety=variety,
        duplicates=close,
        pairs=pairs,
        sizes=tuple(compare_sizes(size, real)),
        real=real,
        dead_parameters=parameters,
        dead_alternatives=alternatives,
        dead_labels=(*find_dead_labels(batch), *find_idle_labels(batch), *find_dead_grasps(batch)),
        lines=known.lines,
        meshes=known.meshes,
        ratios=tuple(compare_ratios(size, real)),
        variants=tuple(variants),
        prior=known.prior,
    )


def _variety(found: Graphs) -> Variety:
    """How different the kinematic graphs of objects are."""
    distance, pairs = measure_distance(found)
    kind, count = found.kinds
    kinds = tuple((found.text[k], int(c)) for k, c in zip(kind[:_SHOWN], count[:_SHOWN], strict=True))
    joints = found.joints
    spread = float(joints.mean()), float(joints.var()), int(joints.min()), int(joints.max())
    return Variety(len(kind), found.perplexity, distance, pairs, *spread, kinds)


def program_lines(text: str) -> int:
    """Lines of a program without blank ones and comments."""
    return sum(1 for line in text.splitlines() if line.strip() and not line.strip().startswith("#"))

"""Quality cards in words: as lines for a terminal, and as a table in Markdown of several categories."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..errors import plural
from .card import Card
from .coverage import LevelPair
from .sizes import Extent

_FEW = 8  # of a list that are told


def card_text(card: Card) -> str:
    """A card in lines: each figure, its goal, whether it is met, and below it what explains it."""
    goals = {goal.figure: goal for goal in card.goals}
    counted = "1 object" if card.objects == 1 else f"{card.objects} objects"
    drawn = f", drawn by the prior {card.prior}" if card.prior else ""
    lines = [
        f"{card.category}: {counted}, seed {card.seed}{drawn}" + ("" if card.checked else ", collisions not checked")
    ]
    for figure, value, remarks in list_figures(card):
        goal = goals.get(figure)
        verdict = "" if goal is None else f"  goal {goal.goal}: {'met' if goal.met else 'NOT MET'}"
        lines.append(f"{figure:<18} {value}{verdict}")
        lines += [f"    {remark}" for remark in remarks]
    return "\n".join(lines)


def list_figures(card: Card) -> Iterator[tuple[str, str, list[str]]]:
    """(name of a figure, its value in words, remarks) for every figure of a card."""
    variety, pairs = card.variety, card.pairs
    failed = [f"{plural(count, 'time')}: {what}" for what, count in card.valid.failed.items()]
    again = card.valid.attempts - card.objects
    yield "valid", f"{100 * card.valid.first / card.objects:.1f}% of first attempts, {again} drawn again", _few(failed)
    why = [f"goal: {card.real.why}"] if card.real is not None and card.real.why else []
    yield "graphs", f"{variety.distinct} distinct, perplexity {variety.perplexity:.1f}", why
    yield "edit distance", f"{variety.distance:.3f} on average, normalised, {variety.pairs} pairs", []
    joints = f"{variety.joints_least} to {variety.joints_most}, mean {variety.joints_mean:.1f}, variance {variety.joints_variance:.1f}"
    yield "joints", joints, []
    yield "duplicates", f"{card.duplicates} ({100 * card.duplicates / card.objects:.1f}%)", []
    seen = f"{pairs.seen} of {pairs.possible} ({_percent(pairs.share)}), {len(pairs.excluded)} more excluded by guards"
    yield "pairs", seen, _few([f"not seen: {_say(pair)}" for pair in pairs.missed])
    yield (
        "sizes",
        _sizes(card),
        [_extent_text(e) for e in card.sizes] + ([card.real.source] if card.real is not None else []),
    )
    if card.ratios:
        yield "ratios", _within(card.ratios), [_ratio_text(e) for e in card.ratios]
    if card.variants:
        there = sum(v.objects > 0 for v in card.variants)
        told = [f"not seen: {v.name} ({v.settings})" for v in card.variants if not v.objects and not v.refused]
        told += [f"--set does not reach {v.name} ({v.settings}): it {v.refused}" for v in card.variants if v.refused]
        yield "variants", f"{there} of {len(card.variants)} seen", _few(told)
    for name, dead in (
        ("dead parameters", card.dead_parameters),
        ("dead alternatives", card.dead_alternatives),
        ("dead labels", card.dead_labels),
    ):
        told = [f"{d.where}: {d.name}{f' = {d.option}' if d.option else ''} {d.why}" for d in dead]
        yield name, str(len(dead)) if dead else "none", _few(told)
    if card.meshes is not None:
        strict = card.meshes
        rest, sweeps, every = (_percent(count / strict.objects) for count in (strict.rest, strict.sweeps, strict.all))
        value = f"{every} of {strict.objects} apart in every state ({rest} at rest, {sweeps} while each joint moves)"
        deepest = sorted(strict.touches, key=lambda touch: -touch.depth)
        yield (
            "meshes",
            value,
            _few(
                [f"object {t.object}: `{t.parts[0]}` and `{t.parts[1]}` share {1e3 * t.depth:.3g} mm" for t in deepest]
            ),
        )
    yield "lines", "compiled" if card.lines is None else str(card.lines), []


def _percent(share: float) -> str:
    """A share in per cent; 100% is kept for all."""
    return "100%" if share >= 1.0 else f"{min(100 * share, 99.9):.1f}%"


def _sizes(card: Card) -> str:
    return _within(card.sizes) or "nothing is known of real ones"


def _within(extents: Sequence[Extent]) -> str:
    known = [f"{e.axis} {100 * e.within:.0f}%" for e in extents if e.within is not None]
    return f"in the range of real ones {', '.join(known)}" if known else ""


def _extent_text(extent: Extent) -> str:
    low, middle, high = (100 * v for v in extent.ours)
    told = f"{extent.axis:<6} {low:.1f} .. {middle:.1f} .. {high:.1f} cm"
    if extent.real is None:
        return told
    low, middle, high = (100 * v for v in extent.real)
    return told + f"; real {low:.1f} .. {middle:.1f} .. {high:.1f}; medians as {extent.ratio:.2f} to 1"


def _ratio_text(extent: Extent) -> str:
    ours, real = (" .. ".join(f"{v:.2f}" for v in values or ()) for values in (extent.ours, extent.real))
    return f"{extent.axis} {ours}; real {real}; medians as {extent.ratio:.2f} to 1"


def _say(pair: LevelPair) -> str:
    return f"{pair.first} = {pair.one} with {pair.second} = {pair.two}"


def _few(told: Sequence[str]) -> list[str]:
    return [*told[:_FEW], f"and {len(told) - _FEW} more"] if len(told) > _FEW else list(told)


HEAD = (
    "category",
    "valid",
    "graphs (goal)",
    "perplexity",
    "edit distance",
    "joints (mean, variance)",
    "near-duplicates",
    "pairs of choices",
    "real size (w, d, h)",
    "ratios (w/h, d/h)",
    "variants",
    "dead",
    "lines",
)


def markdown_table(cards: Sequence[Card]) -> str:
    """A table with a row per category, the goals that are not met, and why a category has as many graphs as it should."""
    seen = any(card.meshes is not None for card in cards)
    head = [*HEAD, *(["meshes apart"] if seen else [])]
    lines = ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1)]
    lines += ["| " + " | ".join(_cells(card) + [_meshes(card)] * seen) + " |" for card in cards]
    missed = [f"{card.category}, {goal.figure} ({goal.goal})" for card in cards for goal in card.goals if not goal.met]
    lines += ["", f"Goals not met: {'; '.join(missed)}." if missed else "All goals are met.", ""]
    lines += [f"* {card.category}: {card.real.why}." for card in cards if card.real is not None and card.real.why]
    return "\n".join(lines).rstrip() + "\n"


def _meshes(card: Card) -> str:
    seen = card.meshes
    return "-" if seen is None else f"{_percent(seen.all / seen.objects)} of {seen.objects}"


def _cells(card: Card) -> list[str]:
    """The row of a card."""
    variety, pairs = card.variety, card.pairs
    goal = "" if card.real is None or card.real.graphs is None else f" ({card.real.graphs})"
    within = [f"{100 * e.within:.0f}" for e in card.sizes if e.within is not None]
    return [
        card.category,
        f"{100 * card.valid.first / card.objects:.1f}%",
        f"{variety.distinct}{goal}",
        f"{variety.perplexity:.1f}",
        f"{variety.distance:.2f}",
        f"{variety.joints_mean:.1f}, {variety.joints_variance:.1f}",
        f"{100 * card.duplicates / card.objects:.1f}%",
        f"{pairs.seen} of {pairs.possible}",
        f"{', '.join(within)}%" if within else "-",
        f"{', '.join(f'{100 * (e.within or 0.0):.0f}' for e in card.ratios)}%" if card.ratios else "-",
        f"{len(card.variants) - len(card.lacking)} of {len(card.variants)}" if card.variants else "-",
        str(len(card.dead_parameters) + len(card.dead_alternatives) + len(card.dead_labels)),
        "-" if card.lines is None else str(card.lines),
    ]

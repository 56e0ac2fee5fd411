"""The tables of README.md, from the files of results: ``python -m experiments.page`` writes them anew."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent


def arms_table(told: dict[str, Any]) -> str:
    """A row for each arm: each metric, with its values by seed for the first."""
    metrics = told["metrics"]
    first = next(iter(metrics))
    rows = [["trained on", *(m["title"] for m in metrics.values()), f"{metrics[first]['title']} by seed"]]
    best = {
        name: (max if m["better"] == "higher" else min)(arm[name]["mean"] for arm in told["arms"].values())
        for name, m in metrics.items()
    }
    for arm, scores in told["arms"].items():
        means = [
            f"**{_tell(scores[name]['mean'], m)}**"
            if scores[name]["mean"] == best[name]
            else _tell(scores[name]["mean"], m)
            for name, m in metrics.items()
        ]
        rows.append([arm, *means, ", ".join(_tell(v, metrics[first]) for v in scores[first]["over_seeds"])])
    return table(rows)


def pairs_table(told: dict[str, Any]) -> str:
    """A row for each comparison: how much one arm is above another, and on how many objects it is better."""
    rows = [["arm", "against", "metric", "difference", "better on", "p"]]
    for pair in told["pairs"]:
        m = told["metrics"][pair["metric"]]
        difference = f"{m['scale'] * pair['difference']:+.{m['digits']}f}"
        rows.append(
            [
                pair["one"],
                pair["other"],
                m["title"],
                difference,
                f"{pair['better_on']} of {pair['of']}",
                chance(pair["p"]),
            ]
        )
    return table(rows)


def chance(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.2g}"


def objects_table(told: dict[str, Any]) -> str:
    """The first metric object by object."""
    name, m = next(iter(told["metrics"].items()))
    rows = [["object", *told["arms"]]]
    for one in next(iter(told["arms"].values()))[name]["objects"]:
        rows.append([one, *(_tell(arm[name]["objects"][one], m) for arm in told["arms"].values())])
    return table(rows)


def steps_table(runs: Sequence[dict[str, Any]]) -> str:
    """The first metric of the arms that were trained for longer, by length, over the seeds that all have."""
    seeds = min(told["seeds"] for told in runs)
    name, m = next(iter(runs[0]["metrics"].items()))
    rows = [["trained on", *(f"{told['steps']:,} steps" for told in runs)]]
    for arm in [arm for arm in runs[0]["arms"] if any(arm in told["arms"] for told in runs[1:])]:
        kept = [told["arms"][arm][name]["over_seeds"][:seeds] if arm in told["arms"] else None for told in runs]
        rows.append([arm, *("-" if values is None else _tell(sum(values) / seeds, m) for values in kept)])
    return table(rows)


def table(rows: list[list[str]]) -> str:
    """Markdown; the first row is the head."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|---|" + "---:|" * (len(rows[0]) - 1), *lines[1:]])


def _tell(value: float, metric: dict[str, Any]) -> str:
    return f"{metric['scale'] * value:.{metric['digits']}f}"


KINDS = {"arms": arms_table, "pairs": pairs_table, "objects": objects_table}
_PLACE = re.compile(r"<!-- (\w+): (\w+) -->\n.*?<!-- end -->", re.DOTALL)


def written(page: str, results: Path) -> str:
    """The page with its tables, each between ``<!-- EXPERIMENT: KIND -->`` and ``<!-- end -->``, as the results have it; those of the folder
    ``longer`` are of more steps."""

    def fill(place: re.Match[str]) -> str:
        experiment, kind = place.groups()
        told, *longer = (
            json.loads(path.read_text(encoding="utf-8"))
            for path in (results / f"{experiment}.json", *(results / "longer").glob(f"{experiment}_*.json"))
        )
        longer.sort(key=lambda one: one["steps"])
        made = steps_table([told, *longer]) if kind == "steps" else KINDS[kind](told)
        return f"<!-- {experiment}: {kind} -->\n{made}\n<!-- end -->"

    return _PLACE.sub(fill, page)


if __name__ == "__main__":
    readme = HERE / "README.md"
    readme.write_text(written(readme.read_text(encoding="utf-8"), HERE / "results"), encoding="utf-8")

"""What simulators make of exported objects, level by level: ``python benchmarks/simulators.py [-n OBJECTS] [CATEGORY ...]``.

The levels are those of ``tests/simulators/levels.py``. Every failure is told, then a table of what passed: simulators and
formats by levels, and how long it took. A simulator whose package is missing is left out and named.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1] / "tests")]

from simulators.levels import LEVELS, climb  # noqa: E402
from simulators.matrix import SHIPPED, SIMULATORS, objects, simulator  # noqa: E402
from simulators.subject import written  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("categories", nargs="*", default=SHIPPED)
    parser.add_argument("-n", type=int, default=2, help="objects of each category")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--joints", type=int, default=6, help="driven joints of an object")
    parser.add_argument("--simulator", action="append", choices=list(SIMULATORS), help="this one alone (repeatable)")
    arguments = parser.parse_args()
    adapters = {name: simulator(name) for name in arguments.simulator or SIMULATORS}
    print("\n".join(f"{name} is not installed and left out" for name, adapter in adapters.items() if adapter is None))
    passed, tried, seconds = Counter(), Counter(), Counter()
    for category in arguments.categories:
        for one in objects(category, arguments.n, arguments.seed):
            robot = one.robot
            for adapter in filter(None, adapters.values()):
                for form in adapter.forms:
                    start = time.perf_counter()
                    with written(robot, form, ways=one.ways, bound=one.bound) as subject:
                        found = climb(adapter, subject, arguments.joints, one.stands)
                    seconds[adapter.name, form] += time.perf_counter() - start
                    for level, text in found.items():
                        tried[adapter.name, form, level] += 1
                        passed[adapter.name, form, level] += not text
                        print(
                            f"{robot.name} {adapter.name} {form}: {level}: {text[:300]}", flush=True
                        ) if text else None
    print(f"\n| simulator | format | {' | '.join(LEVELS)} | s |\n|---|---|{'---:|' * (len(LEVELS) + 1)}")
    for (name, form), time_taken in seconds.items():
        cells = [f"{passed[name, form, level]} of {tried[name, form, level]}" for level in LEVELS]
        print(f"| {name} | `{form}` | {' | '.join(cells)} | {time_taken:.0f} |")


if __name__ == "__main__":
    main()

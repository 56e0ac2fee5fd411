"""Whether a hand can hold what moves, and whether the grasps that are given hold: by exported meshes and code of its own.

    python benchmarks/holding.py [-n OBJECTS] [--seed S] [-v] [CATEGORY ...]

``tests/simulators/fingers.py`` tells what counts. Of the grasps that annotations give at rest for a hand of 8 cm, how many hold; of the
links that joints move and that two fingers can hold at all, how many have a grasp. ``-v`` names what has none and what does not hold.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1] / "tests")]

from simulators.fingers import Hand, Scene  # noqa: E402

from artipg_dsl.annotate.annotation import describe  # noqa: E402
from artipg_dsl.annotate.states import own_joints  # noqa: E402
from artipg_dsl.export.robot import Robots  # noqa: E402
from artipg_dsl.session import Session, categories  # noqa: E402


def turned(quaternion: list[float]) -> np.ndarray:
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def carriers(joints: list[dict], link: str) -> list[str]:
    """A link and all that carry it: what holds a handle moves the door."""
    above = {joint["child"]: joint["parent"] for joint in joints}
    found = [link]
    while found[-1] in above:
        found.append(above[found[-1]])
    return found


def measure(category: str, n: int, seed: int, verbose: bool) -> str:
    batch = Session.of(category).sampler.batch(np.arange(n), seed)
    told, robots = describe(batch), Robots(batch, physics=False)
    moving, first = own_joints(batch) >= 0, np.searchsorted(batch.links().owner, np.arange(n))
    held = given = had = holdable = moves = other = 0
    lacking: Counter[str] = Counter()
    loose: Counter[str] = Counter()
    for i in range(n):
        robot = robots.robot(i)
        scene = Scene(robot)
        names = [link["name"] for link in told[i]["links"]]
        grasped = set()
        for grasp in told[i]["grasps"]:
            link = names.index(grasp["link"])
            grasped |= {names.index(name) for name in carriers(told[i]["joints"], grasp["link"])}
            own = grasp["gripper"] or {}
            if own.get("stroke", 0.0) > Hand.stroke or not grasp["reachable"]:
                other += 1
                continue
            given += 1
            fine = {name: own[word] for name, word in (("width", "width"), ("tip", "pad")) if word in own}
            hand = Hand(np.array(grasp["point"]), turned(grasp["quaternion"]), grasp["opening"], **fine)
            good = scene.holds(hand, link)
            held += good
            if not good:
                why = "free" if not scene.free(hand) else "firm"
                loose[
                    f"{grasp['name']} on {batch.program.links[batch.links().definition[first[i] + link]].path}: not {why}"
                ] += 1
        for link in range(len(names)):
            if not moving[first[i] + link]:
                continue
            moves += 1
            if link in grasped or scene.could(link) is not None:
                holdable += 1
                had += link in grasped
                if link not in grasped:
                    lacking[batch.program.links[batch.links().definition[first[i] + link]].path] += 1
    text = f"{category:18}{held:6} of {given:4} hold  ({other} for another hand)   {had:5} of {holdable:4} links that can be held have one ({moves} move)"
    if verbose:
        text += "".join(f"\n    none on {name}: {count}" for name, count in lacking.most_common())
        text += "".join(f"\n    {name}: {count}" for name, count in loose.most_common())
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("categories", nargs="*", default=categories())
    parser.add_argument("-n", type=int, default=10, help="objects of each category")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-v", action="store_true", help="name what has none, and what does not hold")
    options = parser.parse_args()
    for category in options.categories:
        print(measure(category, options.n, options.seed, options.v), flush=True)


if __name__ == "__main__":
    main()

"""How valid the objects of the shipped categories are, and how far the check of collisions can be trusted.

    python benchmarks/validity.py table [-n 1000] [-o FILE] [CATEGORY ...]     first attempts, repaired, blocking, time
    python benchmarks/validity.py sweep [-n 5] [CATEGORY ...]                  against 1,000 states of every joint, by FCL

``sweep`` widens the range of every joint by 40 % of itself at either end, so that there is something to find, and asks for
each pair of links of each joint whether they ever meet: the check by its proofs over whole intervals, FCL (python-fcl) in
1,000 states of the same convex pieces. A meeting counts where FCL finds a depth of more than 0.1 mm. ``missed`` are pairs that
only FCL finds; ``between`` are pairs that only the check finds, and ``invented`` those of them that FCL does not find either
in the very state that the check names, less a thousandth of a millimetre for rounding.
"""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from artipg_dsl.geometry import pieces
from artipg_dsl.resources import categories_dir
from artipg_dsl.run.job import open_program
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.statistics import Statistics
from artipg_dsl.session import Session
from artipg_dsl.validity.bodies import gather, turn_points
from artipg_dsl.validity.evidence import find_evidence
from artipg_dsl.validity.faults import find_faults
from artipg_dsl.validity.tree import Tree
from artipg_dsl.validity.validate import find_collisions

STATES, DEEP, WIDER = 1000, 1e-4, 0.4


HEAD = """| category | first attempts valid | repaired | delivered valid | joints | blocking pairs | ms sampled | ms checked |
|---|---:|---:|---:|---:|---|---:|---:|"""


def table(name: str, n: int, blocking: int) -> str:
    """One row: first attempts that are valid, how many of the others a repair puts right, delivered objects that are valid,
    joints, pairs of links that block one another and how often, milliseconds of processor time to draw and to check one."""
    sampler, told = open_program(name)[0], Statistics()
    find_faults(sampler.batch(np.arange(8), 0))
    drawn = checked = 0.0
    unsound = repaired = failed = invalid = joints = 0
    for start in range(0, n, 256):
        numbers = np.arange(start, min(start + 256, n))
        begin = time.process_time()
        batch = sampler.batch(numbers, 0, statistics=told)
        middle = time.process_time()
        wrong = find_faults(batch).objects()
        drawn, checked = drawn + middle - begin, checked + time.process_time() - middle
        joints += len(batch.joints().owner)
        unsound += int((batch.state.attempt[wrong] == 0).sum())
        again = numbers[np.union1d(wrong, np.flatnonzero(batch.state.attempt))]
        if len(again):
            invalid += len(find_faults(sampler.batch(again, 0, checked=True)).objects())
            failed += len(again)
            repaired += len(sampler.batch(again, 0, checked=True, mend=True).repairs.objects())
    pairs = find_evidence(sampler.batch(np.arange(min(blocking, n)), 0, checked=True)).blocking
    blocks = ", ".join(f"{pair.first} and {pair.second} ({pair.objects})" for pair in pairs) or "none"
    return (
        f"| {name} | {100 * (told.first_valid - unsound) / n:.1f} % | {f'{repaired} of {failed}' if failed else '-'} "
        f"| {100 * (1 - invalid / n):.1f} % | {joints:,} | {blocks} | {1e3 * drawn / n:.2f} | {1e3 * checked / n:.1f} |"
    )


class Exact:
    """The pieces of one object as solids of FCL."""

    def __init__(self, batch: Batch):
        import fcl

        self.fcl, self.batch, self.tree = fcl, batch, Tree(batch)
        solids, links, boxes = [], [], []
        for site in batch.sites():
            for group in pieces.build(site.primitive, site.params) if len(site) else ():
                rows = group.rows
                sign = np.stack([np.ones(len(rows)), site.mirror[rows], np.ones(len(rows))], axis=-1)
                points = (
                    turn_points(site.rotation[rows], group.vertices * sign[:, None]) + site.translation[rows][:, None]
                )
                faces = np.concatenate([np.full((len(group.faces), 1), 3), group.faces], axis=1).flatten()
                for corners, link in zip(points, site.link[rows].tolist(), strict=True):
                    shape = fcl.Convex(np.ascontiguousarray(corners), len(group.faces), faces)
                    solids.append(fcl.CollisionObject(shape, fcl.Transform()))
                    links.append(link)
                    boxes.append((corners.min(axis=0), corners.max(axis=0)))
        self.solids, self.link, ends = solids, np.array(links), np.array(boxes)
        self.middle, self.half = (ends[:, 0] + ends[:, 1]) / 2, (ends[:, 1] - ends[:, 0]) / 2

    def deepest(self, states: np.ndarray, moving: np.ndarray, found: dict[tuple[int, int], float]) -> None:
        """Note in ``found`` how deep links of ``moving`` penetrate others with the joints at ``states``."""
        fcl = self.fcl
        turn, shift = self.batch.pose(states)
        own = turn[self.link]
        middle = (own * self.middle[:, None]).sum(axis=2) + shift[self.link]
        half = (np.abs(own) * self.half[:, None]).sum(axis=2)
        moves = np.isin(self.link, moving)
        one, two = np.flatnonzero(moves), np.flatnonzero(~moves)
        near = (np.abs(middle[one][:, None] - middle[two]) < half[one][:, None] + half[two]).all(axis=2)
        request = fcl.CollisionRequest(num_max_contacts=4, enable_contact=True)
        for i, j in np.argwhere(near).tolist():
            a, b = one[i], two[j]
            for k in (a, b):
                self.solids[k].setTransform(fcl.Transform(turn[self.link[k]], shift[self.link[k]]))
            result = fcl.CollisionResult()
            if fcl.collide(self.solids[a], self.solids[b], request, result):
                depth = max(abs(contact.penetration_depth) for contact in result.contacts)
                pair = tuple(sorted((int(self.link[a]), int(self.link[b]))))
                found[pair] = max(found.get(pair, 0.0), depth)


def sweep(name: str, n: int) -> tuple[int, int, int, int, int]:
    """Pairs of links that meet for some joint: found by both, missed, found between states, invented; and joints."""
    sampler = Session.of(name).sampler
    both = missed = between = invented = seen = 0
    for number in range(n):
        batch = sampler.batch(np.array([number]), 0, checked=True)
        tree, exact = Tree(batch), Exact(batch)
        wide = WIDER * (tree.high - tree.low)
        tree.low, tree.high = tree.low - wide, tree.high + wide
        found = find_collisions(batch, tree, gather(batch, tree.first, tree.turn, tree.shift))
        rest = tree.joints.rest
        chosen = np.flatnonzero(tree.alone & (tree.turns | tree.slides))
        for joint in chosen[np.linspace(0, len(chosen) - 1, min(6, len(chosen))).astype(int)].tolist():
            moving = np.flatnonzero((tree.chain == tree.child[joint]).any(axis=1))
            truth: dict[tuple[int, int], float] = {}
            for value in np.linspace(tree.low[joint], tree.high[joint], STATES):
                states = rest.copy()
                states[joint] = value
                exact.deepest(states, moving, truth)
            rows = np.flatnonzero(found.joint == joint)
            ours = {tuple(sorted((int(found.first[r]), int(found.second[r])))): float(found.value[r]) for r in rows}
            deep = {pair for pair, depth in truth.items() if depth > DEEP}
            both, missed, seen = both + len(deep & set(ours)), missed + len(deep - set(ours)), seen + 1
            for pair in set(ours) - deep:
                between += 1
                if truth.get(pair, 0.0) <= 0.0 and tree.turns[joint]:
                    at: dict[tuple[int, int], float] = {}
                    states = rest.copy()
                    states[joint] = ours[pair]
                    exact.deepest(states, moving, at)
                    invented += at.get(pair, 0.0) <= 0.0
    return both, missed, between, invented, seen


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("table", "sweep"))
    parser.add_argument("categories", nargs="*")
    parser.add_argument("-n", type=int, help="objects of each category")
    parser.add_argument("--blocking", type=int, default=100, help="objects whose blocking pairs are looked for")
    parser.add_argument("-o", "--output", type=Path, help="a file for the table; rows that it has are left out")
    options = parser.parse_intermixed_args()
    names = options.categories or sorted(path.stem for path in categories_dir().glob("*.apg"))
    if options.what == "table":
        known = options.output.read_text() if options.output and options.output.exists() else ""
        with options.output.open("a") if options.output else nullcontext(sys.stdout) as file:
            if not known:
                print(HEAD, file=file, flush=True)
            for name in names:
                if f"| {name} |" not in known:
                    print(table(name, options.n or 1000, options.blocking), file=file, flush=True)
        return
    print("| category | joints | meetings | missed | between | invented |\n|---|---|---|---|---|---|")
    total = np.zeros(5, dtype=int)
    for name in names:
        found = sweep(name, options.n or 5)
        total += found
        both, missed, between, invented, joints = found
        print(f"| {name} | {joints} | {both + missed} | {missed} | {between} | {invented} |", flush=True)
    both, missed, between, invented, joints = total.tolist()
    print(f"| all | {joints} | {both + missed} | {missed} | {between} | {invented} |")
    print(f"\nrecall {100 * both / max(both + missed, 1):.2f} %")


if __name__ == "__main__":
    main()

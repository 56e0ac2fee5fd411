"""Of every family of grasps of every shipped category, how many the gripper can make: the table of docs/benchmarks.md.

With all joints at rest, with the reasons; with all of them open, as what lies behind a door is for a hand once the door is open; and with only
those open that carry the grasp, and what these wait for, as a drawer that is out may stand before what is above it.

    python benchmarks/grasps.py [--objects 32] [--gripper standard] [CATEGORY ...]
"""

from __future__ import annotations

import argparse

import numpy as np

from artipg_dsl.annotate.grasps import GraspTable, sample_grasps
from artipg_dsl.annotate.gripper import REASONS, Gripper, judge, read_gripper
from artipg_dsl.annotate.states import joint_values, open_values, read_states, rest_values
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.runtime.detents import caught
from artipg_dsl.session import Session, categories


def judge_alone(batch: Batch, grasps: GraspTable, gripper: Gripper) -> np.ndarray:
    """As ``judge``, of each grasp with only the joints open that carry its link, and what they wait for."""
    joints, owner = batch.joints(), np.asarray(batch.links().owner)
    first, rest = np.searchsorted(owner, np.arange(len(batch))), rest_values(batch)
    low, high = (np.where(np.isnan(end), rest, end) for end in (joints.low, joints.high))
    start, above = first[joints.owner], np.full(len(owner), -1)
    above[start + joints.child] = np.arange(len(joints.owner))
    verdict = np.zeros(len(grasps.owner), dtype=np.int64)
    for number in np.unique(grasps.link):  # one link of each object at a time
        mine = np.flatnonzero(grasps.link == number)
        carries, at = np.zeros(len(rest), dtype=bool), np.unique(first[grasps.owner[mine]] + number)
        while len(at := at[above[at] >= 0]):
            carries[above[at]] = True
            at = start[above[at]] + joints.parent[above[at]]
        values = caught(joints, np.where(carries, open_values(batch), rest))
        if batch.gates is not None:
            values = np.where(carries, values, batch.gates.open(values, carries, low, high))
        verdict[mine] = judge(batch, grasps, gripper, batch.settle(values))[mine]
    return verdict


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("categories", nargs="*")
    parser.add_argument("--objects", type=int, default=32)
    parser.add_argument("--gripper", default="standard")
    options = parser.parse_args()
    gripper = read_gripper(options.gripper)
    if gripper is None:
        parser.error("give a gripper to judge by")
    print(
        "| category | grasp | tried | feasible | too wide | blocked | empty | feasible, open | feasible, itself open |"
    )
    print("|---|---|" + "---:|" * 7)
    for category in options.categories or categories():
        batch = Session.of(category).sampler.batch(np.arange(options.objects), 5)
        grasps = sample_grasps(batch)
        (opened,) = joint_values(batch, read_states("open"))
        shut, names = judge(batch, grasps, gripper), np.array(grasps.name)
        ways = judge(batch, grasps, gripper, opened), judge_alone(batch, grasps, gripper)
        for name in dict.fromkeys(grasps.name):
            own = names == name
            shares = [np.mean(shut[own] == reason) for reason in range(len(REASONS))]
            shares += [np.mean(verdict[own] == 0) for verdict in ways]
            cells = "".join(f" {100 * share:.0f} % |" for share in shares)
            print(f"| {batch.program.name} | `{name}` | {own.sum()} |{cells}", flush=True)


if __name__ == "__main__":
    main()

"""Of every family of grasps of every shipped category, how many the gripper can make: the table of docs/benchmarks.md.

With all joints at rest, with the reasons, and with all of them open: what lies behind a door is for a hand once the door is open.

    python benchmarks/grasps.py [--objects 32] [--gripper standard]
"""

from __future__ import annotations

import argparse

import numpy as np

from artipg_dsl.annotate.grasps import sample_grasps
from artipg_dsl.annotate.gripper import REASONS, judge, read_gripper
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.session import Session, categories


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=int, default=32)
    parser.add_argument("--gripper", default="standard")
    options = parser.parse_args()
    gripper = read_gripper(options.gripper)
    if gripper is None:
        parser.error("give a gripper to judge by")
    print("| category | grasp | tried | feasible | too wide | blocked | empty | feasible, open |")
    print("|---|---|" + "---:|" * 6)
    for category in categories():
        batch = Session.of(category).sampler.batch(np.arange(options.objects), 5)
        grasps = sample_grasps(batch)
        (opened,) = joint_values(batch, read_states("open"))
        shut, names = judge(batch, grasps, gripper), np.array(grasps.name)
        wide = judge(batch, grasps, gripper, opened)
        for name in dict.fromkeys(grasps.name):
            own = names == name
            shares = [np.mean(shut[own] == reason) for reason in range(len(REASONS))] + [np.mean(wide[own] == 0)]
            cells = "".join(f" {100 * share:.0f} % |" for share in shares)
            print(f"| {batch.program.name} | `{name}` | {own.sum()} |{cells}", flush=True)


if __name__ == "__main__":
    main()

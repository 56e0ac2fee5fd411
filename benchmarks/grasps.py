"""Of every family of grasps of every shipped category, how many the gripper can make with all joints at rest.

python benchmarks/grasps.py [--objects 32] [--gripper standard]
"""

from __future__ import annotations

import argparse

import numpy as np

from artipg_dsl.annotate.grasps import sample_grasps
from artipg_dsl.annotate.gripper import REASONS, judge, read_gripper
from artipg_dsl.session import Session, categories


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=int, default=32)
    parser.add_argument("--gripper", default="standard")
    options = parser.parse_args()
    gripper = read_gripper(options.gripper)
    if gripper is None:
        parser.error("give a gripper to judge by")
    print(f"{'category':18}{'grasp':16}{'tried':>7}" + "".join(f"{reason:>11}" for reason in REASONS))
    for category in categories():
        batch = Session.of(category).sampler.batch(np.arange(options.objects), 5)
        grasps = sample_grasps(batch)
        verdict, names = judge(batch, grasps, gripper), np.array(grasps.name)
        for name in dict.fromkeys(grasps.name):
            counts = np.bincount(verdict[names == name], minlength=len(REASONS))
            shares = "".join(f"{100 * count / counts.sum():10.0f}%" for count in counts)
            print(f"{category:18}{name:16}{counts.sum():7}{shares}")


if __name__ == "__main__":
    main()

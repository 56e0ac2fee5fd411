"""Links that a text lets overlap: no simulator pushes them apart."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.export.mjcf import mjcf_files
from artipg_dsl.export.urdf import urdf_files
from artipg_dsl.export.usd import usd_files
from artipg_dsl.robot.adjacent import find_adjacent
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session

# a spindle through two nuts, of which but one carries it; an object of the batch has the second nut, another has not
SPINDLE = """apg 1
use primitives { Cuboid, Cylinder }
category Spindle {
  root part bench : Cuboid(size = [10cm, 40cm, 2cm])
  part near : Cuboid(size = [4cm, 2cm, 4cm])
  align near.bottom = bench.top + 1mm
  align near.left = bench.left - 2cm
  joint slide_near : prismatic bench -> near along y range 0 .. 1cm
  part rod : Cylinder(radius = 5mm, height = 30cm) along y
  align rod.center.z = near.center.z
  joint wind : continuous near -> rod about rod.axis
  allow overlap near, rod because "it turns in its bearing"
  part far : Cuboid(size = [4cm, 2cm, 4cm]) | none
  when far {
    align far.bottom = bench.top + 1mm
    align far.right = bench.right + 6cm
    joint slide_far : prismatic bench -> far along y range 0 .. 1cm
    allow overlap far, rod because "the nut has a thread"
  }
}
"""


@pytest.fixture(scope="module")
def robots() -> Robots:
    return Robots(Session.of_text(SPINDLE).sampler.batch(np.arange(8), 0))


def test_pairs_that_may_overlap_are_told_to_simulators(robots: Robots) -> None:
    mujoco = pytest.importorskip("mujoco")
    seen = set()
    for i in range(8):
        robot = robots.robot(i)
        threaded = any(link.name == "far" for link in robot.links)
        seen.add(threaded)
        pairs = {frozenset(pair) for pair in find_adjacent(robot)}
        assert (frozenset(("far", "rod")) in pairs) == threaded
        assert len(pairs) == len(find_adjacent(robot)) == (4 if threaded else 2)
        files = mjcf_files(robot)
        meshes = {name: data for name, data in files.items() if name.endswith(".obj")}
        model = mujoco.MjModel.from_xml_string(files["scene.xml"].decode(), assets=files | meshes)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        for _ in range(100):
            mujoco.mj_step(model, data)
        assert abs(data.joint("wind").qpos[0]) < 1e-3, "the nut pushes the rod round"
    assert seen == {True, False}


def test_urdf_and_usd_tell_them_too(robots: Robots) -> None:
    i = next(i for i in range(8) if any(link.name == "far" for link in robots.robot(i).links))
    urdf = urdf_files(robots.robot(i))
    assert b'link1="rod" link2="far" reason="Default"' in urdf["object.srdf"]
    assert b"group=" in urdf["object.urdf"]
    pxr = pytest.importorskip("pxr", reason="usd-core is not installed")
    from pxr import Usd, UsdPhysics

    assert pxr
    stage = Usd.Stage.CreateInMemory("object.usda")
    assert stage.GetRootLayer().ImportFromString(usd_files(robots, i)["object.usda"].decode())
    rod = next(prim for prim in stage.Traverse() if prim.GetDisplayName() == "rod")
    (target,) = UsdPhysics.FilteredPairsAPI(rod).GetFilteredPairsRel().GetTargets()
    assert stage.GetPrimAtPath(target).GetDisplayName() == "far"

"""The Python interface."""

from __future__ import annotations

import json
import re
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.diagnostics import CompileError
from artipg_dsl.errors import NoObject, SettingError, UsageError, UserError

CHEST = Path(__file__).parent / "cli" / "programs" / "chest.apg"
OPEN_ENDED = """apg 1
use primitives { Cuboid }
category Board {
  count m in 1 .. 3
  count n in 1 .. 2 * m
  root part board : Cuboid(size = [n * 10cm, 1cm, 1cm])
}
"""


@pytest.fixture(scope="module")
def chests() -> apg.Samples:
    return apg.sample(CHEST, n=12, seed=7)


def test_values_by_name(chests: apg.Samples) -> None:
    assert len(chests) == 12 and repr(chests) == "<Chest: 12 objects, seed 7>"
    assert chests["width"].shape == (12,) and ((chests["width"] >= 0.3) & (chests["width"] <= 0.6)).all()
    assert set(chests["wood"]) <= {"oak", "pine"} and set(chests["knobs"]) <= {1, 2, 3}
    with pytest.raises(KeyError, match="^Chest draws no `wdith` "):
        chests["wdith"]
    assert "width" in chests and "wdith" not in chests


def test_an_object_is_one_of_the_samples(chests: apg.Samples) -> None:
    chest = chests.object(7)
    assert chest.number == 7 and chest.drawn["width"] == chests["width"][7]
    assert chest.annotation == chests.annotations()[7]
    assert chest.points(16).position.tobytes() == chests.points(16).position[7].tobytes()
    assert chests.object(5000).drawn["width"] == apg.sample(CHEST, numbers=[5000], seed=7)["width"][0]


def test_values_are_set_with_units_or_in_si() -> None:
    a = apg.sample(CHEST, n=3, set={"width": "45cm", "wood": "pine", "knobs": 2})
    b = apg.sample(CHEST, n=3, set={"width": 0.45, "wood": "pine", "knobs": "2"})
    assert (apg.sample(CHEST, set={"width": np.float32(0.5), "knobs": np.int64(2)})["width"] == 0.5).all()
    assert (a["width"] == 0.45).all() and (a["wood"] == "pine").all()
    assert a.points(8).position.tobytes() == b.points(8).position.tobytes()


@pytest.mark.parametrize(
    "fixed", [{"width": 45}, {"width": True}, {"wood": 1}, {"knobs": 2.5}, {"width": "45"}, {"?": 1}]
)
def test_wrong_settings(fixed: dict) -> None:
    with pytest.raises(SettingError):
        apg.sample(CHEST, set=fixed)


def test_settings_that_exclude_each_other() -> None:
    with pytest.raises(SettingError, match=r"no object has `pad\.columns` with pad=DialPad"):
        apg.sample("Microwave", n=1, set={"pad": "DialPad", "pad.columns": 3})
    with pytest.raises(SettingError, match="`handle.thickness` with handle=none"):
        apg.sample("Microwave", n=1, set={"handle.thickness": "1cm", "handle": "none"})
    keys = apg.sample("Microwave", n=1, set={"pad": "KeyPad", "pad.columns": 3})
    assert keys["pad.columns"].tolist() == [3]


def test_wrong_numbers() -> None:
    for arguments in ({"n": 0}, {"n": -1}, {"numbers": []}, {"numbers": [-1]}, {"n": 2, "numbers": [1]}):
        with pytest.raises(UsageError):
            apg.sample(CHEST, **arguments)


def test_what_cannot_be_made() -> None:
    with pytest.raises(CompileError, match="did you mean `Microwave`"):
        apg.sample("Microvave")
    with pytest.raises(NoObject, match=r"no legal value is left for `height` under `height <= 0.8 \* width`") as caught:
        apg.sample(CHEST, set={"width": "30cm", "height": "40cm", "swing": "90deg"})
    assert caught.value.hint is not None
    assert "`width=30cm` and `height=40cm`" in caught.value.hint and "swing" not in caught.value.hint


def test_an_original_none_of_whose_mutants_is_valid_is_named_once() -> None:
    text = """apg 1
use primitives { Cuboid }
template Bare {
  param size : length[3]
  count n in 0 .. 1
  when n > 0 { part c : Cuboid(size = size)  align c.center = center }
}
category Maybe {
  root part body : Bare(size = [1cm, 1cm, 1cm])
}
"""
    with pytest.raises(NoObject, match="for object 0; what failed most"):
        apg.load(text).mutate("dpa", n=3)


def test_a_program_as_text() -> None:
    text = "apg 1\nuse primitives { Cuboid }\ncategory Brick { root part body : Cuboid(size = [10cm, 20cm, 6cm]) }\n"
    brick = apg.load(text)
    assert brick.category == "Brick"
    assert np.allclose(brick.meshes()[0].extents, [0.1, 0.2, 0.06])
    with pytest.raises(CompileError, match="Cuboidd"):
        apg.load(text.replace(": Cuboid", ": Cuboidd"))


def test_several_mutants_of_each(chests: apg.Samples) -> None:
    some = apg.sample(CHEST, numbers=[3, 8], seed=7)
    made, alone = some.mutate("cpa", n=3), [some.mutate("cpa", variant=k) for k in range(3)]
    assert made.numbers.tolist() == [*range(6)]
    assert [one.drawn for one in made] == [one.object(n).drawn for n in (3, 8) for one in alone]
    assert made.object(4).mutate("cpa", n=2).numbers.tolist() == [0, 1]
    focused = some.mutate(one="width", n=2)
    assert len(focused) == 6 and focused.object(3).drawn == some.object(8).drawn
    for n in (0, 10**9, "3"):
        with pytest.raises(UsageError, match=f"^n is {n!r}"):
            some.mutate(n=n)  # type: ignore[arg-type]


def test_tables_share_owners(chests: apg.Samples) -> None:
    links, joints, parts = chests.links(), chests.joints(), chests.parts()
    assert (np.bincount(links.owner) == 2).all() and (np.bincount(joints.owner) == 1).all()
    assert (np.bincount(parts.owner) == 2 + chests["knobs"]).all()


def test_points_follow_the_joints(chests: apg.Samples) -> None:
    rest, opened = chests.points(128), chests.points(128, chests.states(open=1.0))
    lid = rest.link == 1
    assert lid.any() and not lid.all()
    assert np.array_equal(rest.position[~lid], opened.position[~lid])
    assert np.array_equal(rest.semantic, opened.semantic) and np.array_equal(rest.u, opened.u)
    turned = np.sum(rest.normal[lid] * opened.normal[lid], axis=-1)
    across = np.abs(rest.normal[lid][:, 1]) < 0.5
    assert np.allclose(turned[across], np.cos(1.0)) and np.allclose(turned[~across], 1.0)
    with pytest.raises(UserError, match="its joints are open"):
        chests.states(shut=1.0)


def test_tables_and_clouds_show_what_they_hold_and_what_numbers_mean(chests: apg.Samples) -> None:
    cloud = chests.points(32)
    count = len(chests)
    assert f"position ({count}, 32, 3) float64" in " ".join(repr(cloud).split())
    assert max(map(len, repr(chests.joints()).splitlines())) < 80 and "list of" in repr(chests.joints())
    views = repr(chests.views(1, width=32, height=24))
    assert "images['depth']" in views and f"({count}, 1, 24, 32) float32" in views
    assert chests.words["semantic"][0] == "unlabelled"
    assert {chests.words["semantic"][k] for k in np.unique(cloud.semantic)} == {"body", "door", "handle"}


def test_states_are_values_or_text_everywhere(chests: apg.Samples) -> None:
    one, lid = chests.object(int(chests.numbers[0])), {"open": 1.0}
    opened = one.states(**lid)
    named = f"open={np.degrees(1.0):.17g}deg"
    assert np.allclose(one.points(64, named).position, one.points(64, opened).position)
    assert one.points(64, "rest,open").position.shape == (1, 2, 64, 3)
    for states, count in ((named, 1), (opened, 1), ("open,random:2", 3), (one.joint_values("random:2"), 2)):
        (told,) = one.annotations(states)
        assert len(told["states"]) == count
    (told,) = one.annotations(named)
    assert told["states"] == one.annotations(opened)[0]["states"] and told["states"][0]["joints"][0]["value"] == 1.0
    assert np.allclose(one.mesh(named).bounds, one.mesh(opened).bounds)
    assert one.views(1, states="open", width=32, height=24).images["depth"].shape == (1, 1, 24, 32)
    assert one.views(1, states="random:2", width=32, height=24).images["depth"].shape == (1, 2, 1, 24, 32)
    with pytest.raises(UsageError, match="out of reach"):  # as in text
        one.states(open=99.0)
    for wrong in (lid, np.zeros(5), np.array(["open"]), 1.2):
        for ask in (one.points, one.annotations, one.mesh, one.meshes):
            with pytest.raises(UserError, match="states are text or joint values, one for each of 1 joints"):
                ask(states=wrong)  # type: ignore[operator]
    with pytest.raises(UserError, match="2 states, where one is shown at a time"):
        one.mesh("rest,open")
    with pytest.raises(UserError, match="no joint `lid`"):
        one.points(64, "lid=20%")


def test_joint_values_beyond_the_limits_are_refused(chests: apg.Samples) -> None:
    for within in (chests.opened(), chests.joint_values("open=100%,random:3")):
        assert (chests.points(4, within.astype(np.float32)).position - chests.points(4, within).position).max() < 1e-6
    beyond = np.stack([chests.rest(), chests.rest()])
    beyond[1, -1] = 9.0
    joints = chests.joints()
    told = f"joint `{joints.name[-1]}` of object {chests.numbers[joints.owner[-1]]} cannot be at 9: it moves from 0 to "
    for ask in (chests.points, chests.annotations):
        with pytest.raises(UsageError, match=re.escape(told)):
            ask(states=beyond)
    with pytest.raises(UsageError, match="cannot be at"):
        chests.meshes(-1 - chests.opened())


def test_what_everything_is_computed_from_is_not_changed_by_accident(chests: apg.Samples) -> None:
    before = chests.points(8).position
    rest = chests.rest()
    rest[:] = chests.opened()  # as one does who sets a joint
    assert (chests.rest() != rest).any() and (chests.points(8).position == before).all()
    assert (chests.points(8, rest).position != before).any()
    repaired = chests.repairs().after
    for array in (chests.numbers, chests.links().translation, chests.joints().high, chests.parts().low, repaired):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0
    chests.links().name.clear()
    assert len(chests.links().name) == len(chests.links().owner)


def test_a_folder_of_a_program_given_as_text_says_so(tmp_path: Path) -> None:
    text = "apg 1\nuse primitives { Cuboid }\ncategory Slab { root part body : Cuboid(size = [1m, 1m, 1m]) }\n"
    slab = apg.load(text)
    folder = slab.to(tmp_path / "out", points=4)
    with pytest.raises(UserError, match="a program `Slab` that is neither shipped nor in a file"):
        apg.open_samples(folder)
    with pytest.raises(KeyError, match="it draws nothing"):
        slab["width"]
    with pytest.raises(UsageError, match="it has none at all"):
        slab.states(open=1)


def test_the_end_of_a_domain_that_is_known_is_told() -> None:
    text = """apg 1
use primitives { Cuboid }
category Slab {
  param wide : length in 10cm .. 20cm = 15cm
  param deep : length in wide / 2 .. 52mm = 52mm
  root part body : Cuboid(size = [deep, wide, 1cm])
}
"""
    for value, words in (("9m", "`deep` cannot be 9m: it is at most 5.2cm"), ("9", "for example deep=5.2cm")):
        with pytest.raises(UserError, match=words):
            apg.load(text, set={"deep": value})


def test_details_that_a_folder_keeps_from_other_objects_are_told(tmp_path: Path) -> None:
    slab = apg.load(
        "apg 1\nuse primitives { Cuboid }\ncategory Slab { root part body : Cuboid(size = [1m, 1m, 1m]) }\n"
    )
    out = slab.to(tmp_path / "out", points=4)
    (out / "details").mkdir()
    (out / "details" / "bind.json").write_text("{}")
    with pytest.warns(UserWarning, match="details holds details that these objects do not wear: remove it"):
        slab.to(out, points=8, force=True)
    assert (out / "details" / "bind.json").exists(), "someone may have bound them by hand"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        slab.to(out, points=8)


def test_an_array_without_axes_is_a_number() -> None:
    assert apg.sample(CHEST, set={"width": np.array(0.5), "knobs": np.array(2)})["width"] == [0.5]


def test_what_is_taken_for_no_is_not_written_over(chests: apg.Samples, tmp_path: Path) -> None:
    (made,) = chests.object(0).to_urdf(tmp_path)
    before = made.stat().st_mtime_ns
    with pytest.raises(UsageError, match="force is 'no'"):
        chests.object(0).to_urdf(tmp_path, force="no")
    assert made.stat().st_mtime_ns == before


def test_arrays_of_numpy_are_numbers_everywhere(chests: apg.Samples) -> None:
    given = {"poses": [{"eye": [2, 0.5, 0.8]}], "width": 8, "height": 8, "fov": 30}
    arrays = given | {"poses": [{"eye": np.array([2, 0.5, 0.8])}], "fov": np.float32(30), "width": np.int64(8)}
    assert (chests.views(arrays).images["depth"] == chests.views(given).images["depth"]).all()
    ranged = [chests.views(1, width=8, height=8, azimuth=a).extrinsics for a in ([0, 90], np.array([0, 90]))]
    assert (ranged[0] == ranged[1]).all()
    drawn = [apg.sample(CHEST, 3, prior={"width": w})["width"] for w in ([0.4, 0.45], np.array([0.4, 0.45]))]
    assert (drawn[0] == drawn[1]).all() and (drawn[0] <= 0.45).all()


def test_meshes_are_closed_and_where_the_points_are(chests: apg.Samples) -> None:
    states = chests.opened()
    points = chests.points(64, states)
    for i, scene in enumerate(chests.meshes(states)):
        assert all(mesh.is_watertight and mesh.volume > 0 for mesh in scene.geometry.values())
        low, high = scene.bounds
        assert (points.position[i] >= low - 1e-9).all() and (points.position[i] <= high + 1e-9).all()
    assert {"trunk", "lid"} <= set(scene.geometry)
    assert scene.geometry["lid"].metadata["link"] == "lid"


def test_files(chests: apg.Samples, tmp_path: Path) -> None:
    few = apg.sample(CHEST, numbers=[3, 8], seed=7)
    urdf, glb = few.to_urdf(tmp_path / "u"), few.to_glb(tmp_path / "g")
    assert [path.parent.name for path in urdf] == ["000003", "000008"] and all(p.exists() for p in [*urdf, *glb])
    assert few.to(tmp_path / "d", "points", points=32) == tmp_path / "d"
    again = apg.open_samples(tmp_path / "d")
    assert again.numbers.tolist() == [3, 8] and again["width"].tolist() == few["width"].tolist()
    with np.load(tmp_path / "d" / "points-00000.npz") as arrays:
        assert arrays["points"].tobytes() == chests.points(32).position[[3, 8]].astype(np.float32).tobytes()


def test_a_notebook_shows_objects(chests: apg.Samples, tmp_path: Path) -> None:
    png = chests._repr_png_()
    assert png[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", png[16:24])[0] % 220 == 0
    html = chests._repr_html_()
    assert "data:image/png;base64," in html and "Chest: 12 objects, seed 7, the first 8 shown" in html
    assert chests.object(2).sheet(tmp_path / "s.png", tile=48).read_bytes()[:4] == b"\x89PNG"


def test_grasps_and_keypoints_of_the_microwave() -> None:
    oven = apg.sample("Microwave", n=1, seed=7, set={"handle": "BarHandle"})
    assert oven.grasps(3).name.count("pull_handle") == 3 and set(oven.grasps(3).name) <= {"pull_handle", "turn_knob"}
    assert "door_corner" in oven.keypoints().name


def test_points_and_views_in_several_states(chests: apg.Samples, tmp_path: Path) -> None:
    states = chests.joint_values("rest,random:2")
    assert states.shape == (3, len(chests.rest())) and (states[0] == chests.rest()).all()
    points = chests.points(16, states, motion=True)
    assert points.position.shape == points.motion.shape == (12, 3, 16, 3)
    views = chests.views(2, width=40, height=30, points=20, states=states, azimuth=(-20, 20))
    assert views.images["depth"].shape == (12, 3, 2, 30, 40) and views.cloud["points"].shape == (12, 3, 2, 20, 3)
    one = chests.object(7).views({"views": 2, "width": 40, "height": 30, "points": 20, "azimuth": [-20, 20]})
    assert one.images["depth"][0].tobytes() == views.images["depth"][7, 0].tobytes()
    for wrong in ({"n": 0}, {"n": "none.json"}, {"n": 2, "widht": 40}, {"n": 2, "fov": 0}):
        with pytest.raises(UserError):
            chests.views(**wrong)
    folder = chests.object(3).to(tmp_path / "o", "points", points=16, states="open", motion=True, views=1)
    with np.load(folder / "points-00000.npz") as arrays:
        assert arrays["motion"].shape == (1, 1, 16, 3)
    assert (folder / "views-00000.npz").exists()


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (lambda: apg.sample(CHEST, n=2.5), "n is 2.5"),
        (lambda: apg.sample(CHEST, n="3"), "n is '3'"),
        (lambda: apg.sample(CHEST, n=True), "n is True"),
        (lambda: apg.sample(CHEST, seed="a"), "seed is 'a'"),
        (lambda: apg.sample(CHEST, checked="no"), "checked is 'no'"),
        (lambda: apg.sample(CHEST, repair=1), "repair is 1"),
        (lambda: apg.sample(CHEST, prior=3), "a prior is a name, a file"),
        (lambda: apg.sample(CHEST, frame=90), "a frame is a name or a file"),
        (lambda: apg.sample(CHEST, numbers=[1.5]), "are whole numbers, not"),
        (lambda: apg.sample(CHEST, set="width=45cm"), "it maps names to values"),
        (lambda: apg.sample(CHEST, set={"width": float("nan")}), "cannot be nan"),
        (lambda: apg.sample(CHEST, set={"width": 10**309}), "`width`: the number is too large"),
        (lambda: apg.load(OPEN_ENDED, set={"n": float("inf")}), "`n` cannot be inf"),
        (lambda: apg.sample(CHEST, values=[]), "no objects are given"),
        (lambda: apg.sample(CHEST, values=[{}]).object(1), "there is no object 1: 1 are given"),
        (lambda: apg.sample(CHEST, set={3: 4}), "it maps names to values"),
        (lambda: apg.sample(CHEST, values=3), "values is 3"),
        (lambda: apg.sample(CHEST, values=[3]), "values is [3]"),
        (lambda: apg.load("chest.apg"), "takes the text of a program"),
        (lambda: apg.load("Microwave"), "takes the text of a program"),
        (lambda: apg.load(3), "takes the text of a program"),
        (lambda: apg.sample(None), "a category is a name or a file, not None"),
        (lambda: apg.sample(["Mug"]), "a category is a name or a file, not ['Mug']"),
        (lambda: apg.open_samples(None), "a folder is named by a text or a Path, not None"),
        (lambda: apg.open_samples(""), "the name of a folder is empty text"),
        (lambda: apg.sample("Mug", 1).to(b"x"), "a folder is named by a text or a Path, not b'x'"),
        (lambda: apg.sample(""), "a category is a name or a file, not ''"),
        (lambda: apg.sample(CHEST, n=10**12), "n is 1000000000000 (give a number up to 100,000,000"),
        (lambda: apg.sample(CHEST, numbers=np.zeros((2, 2), int)), "not an array of shape (2, 2)"),
        (lambda: apg.sample(CHEST, sampling=3), "unknown sampling `3`"),
        (lambda: apg.sample(CHEST).points(8, apg.sample(CHEST).joint_values("random:2")[:0]), "no states are given"),
        (lambda: apg.sample(CHEST).rebind(None), "points is None"),
        (lambda: apg.sample(CHEST).meshes(tolerance="1mm"), "tolerance=1mm is not a distance"),
        (lambda: apg.sample(CHEST).mutate(None), "operations is None"),
        (lambda: apg.sample(CHEST).mutate("cpa", only=3), "only is 3"),
        (lambda: apg.sample(CHEST).replay(None), "records is None"),
        (lambda: apg.sample(CHEST).to("", "tables"), "the name of a folder is empty text"),
        (lambda: apg.sample(CHEST).object(-1), "number is -1"),
        (lambda: apg.sample(CHEST).object("1"), "number is '1'"),
        (lambda: apg.sample(CHEST).object(2**63), "number is 9223372036854775808 (give a whole number up to"),
        (lambda: apg.sample(CHEST, numbers=[2**63 - 1]), "there is no object 9223372036854775807"),
        (lambda: apg.sample(CHEST, numbers=[2**64]), "there is no object 18446744073709551616"),
        (lambda: apg.sample(CHEST, numbers=[4, -1]), "there is no object -1"),
        (lambda: apg.sample(CHEST, numbers=[]), "`numbers` is empty"),
        (lambda: apg.sample(CHEST, numbers=[[1, 2], [3]]), "one list, not a list of lists"),
        (lambda: apg.sample(CHEST, numbers=range(10**12)), "1,000,000,000,000 object numbers"),
        (lambda: apg.sample(CHEST, prior={"width": np.zeros(3)}), "the prior: `width` is a list"),
        (lambda: 3 in apg.sample(CHEST), "37 in batch.numbers"),
        (lambda: apg.sample(CHEST)["wdith"], "Chest draws no `wdith` (did you mean `width`?)"),
        (lambda: apg.sample(CHEST).points(8, motion="no"), "motion is 'no'"),
        (lambda: apg.sample(CHEST).points(8, details=3), "details is 3"),
        (lambda: apg.sample(CHEST).points(8, details="x", detail_strength="1"), "the strength of details is '1'"),
        (lambda: apg.sample(CHEST).grasps(10**6), "values is 1000000 (give a whole number up to 10,000)"),
        (lambda: apg.sample(CHEST).to("unused", motion="no"), "motion is 'no'"),
        (lambda: apg.sample(CHEST).to("unused", force="no"), "force is 'no'"),
        (lambda: apg.sample(CHEST).to("unused", 3), "formats is 3"),
        (lambda: apg.sample(CHEST).to("unused", states=None), "states is None: text is needed"),
        (lambda: apg.sample(CHEST).export("unused", "urdf", force="no"), "force is 'no'"),
        (lambda: apg.sample(CHEST).export("unused", [3]), "formats is [3]"),
        (lambda: apg.sample(CHEST).export("", "urdf"), "the name of a folder is empty text"),
        (lambda: apg.sample(CHEST).export("a\0b", "urdf"), "the name of a folder has a zero byte in it"),
        (lambda: apg.sample(CHEST).export("s3://robots", "urdf"), "writes into folders of this machine"),
        (lambda: apg.sample(CHEST).to_urdf(None), "a folder is named by a text or a Path, not None"),
        (lambda: apg.sample(CHEST).lay_out("unused", "cage", force="no"), "force is 'no'"),
        (lambda: apg.sample(CHEST).lay_out("", "cage"), "the name of a folder is empty text"),
        (lambda: apg.sample(CHEST).lay_out("unused", None), "a layout is named by a text, not None"),
        (lambda: apg.sample(CHEST).sheet(None), "a picture is named by a text or a Path, not None"),
        (lambda: apg.sample(CHEST).sheet("x.png", color="part"), "a picture has no 'color' (did you mean `colour`?)"),
        (lambda: apg.sample(CHEST).sheet("x.png", columns=0), "columns is 0"),
        (lambda: apg.sample(CHEST).sheet("x.png", tile="64"), "tile is '64'"),
        (lambda: apg.sample(CHEST).sheet("x.png", states=apg.sample(CHEST).rest()), "unknown states array"),
        (lambda: apg.sample(CHEST).states(open="60deg"), 'batch.points(2048, "open=60deg")'),
        (lambda: apg.sample(CHEST).states(open=np.nan), "open is nan (give a finite number)"),
        (lambda: apg.sample(CHEST).points(8, balance="link", weights=3), "weights is 3"),
        (lambda: apg.sample(CHEST).lay_out("unused", "partnet-seg", split=(8, 1, 1)), "(8, 1, 1) is not a split"),
        (lambda: apg.sample(CHEST).lay_out("unused", "partnet-seg", map={"Chest": 3}), "map is not a map of words"),
        (lambda: apg.sample(CHEST).joint_values(3), "states are text"),
        (lambda: apg.sample(CHEST)[3], "batch.object"),
        (lambda: apg.sample(CHEST).points(8, np.full_like(apg.sample(CHEST).rest(), np.nan)), "values are finite"),
        (lambda: apg.sample(CHEST).grasps(0), "values is 0"),
        (lambda: apg.sample(CHEST).annotations(gripper=3), "a gripper is text or a Gripper"),
        (lambda: apg.sample(CHEST).views(1.5), "number of views is 1.5"),
        (lambda: apg.sample(CHEST).meshes(triangles=99.5), "triangles is 99.5"),
        (lambda: apg.sample(CHEST).replay([]), "no record to repeat"),
        (lambda: apg.sample(CHEST).sheet("sheet.jpg"), "written as PNG"),
        (lambda: apg.sample(CHEST).points(8, detail_strength=0.5), "detail_strength scales details"),
        (lambda: apg.sample(CHEST).to("unused", "annotation", motion=True), "motion applies to points"),
        (lambda: apg.sample(CHEST).to("unused", "points", tolerance=1e-3), "tolerance and triangles apply to meshes"),
        (lambda: apg.sample(CHEST).to("unused", "tables", states="open"), "states does not apply to values alone"),
    ],
)
def test_wrong_arguments_are_told_in_words(wrong, told: str) -> None:
    with pytest.raises(UsageError, match=re.escape(told)):
        wrong()


def test_one_by_one() -> None:
    batch = apg.sample(CHEST, numbers=[4, 2])
    assert [(one.number, one["width"][0]) for one in batch] == list(zip([2, 4], batch["width"], strict=True))
    assert apg.sample(CHEST, values=batch.object(4).drawn)["width"] == batch["width"][1]
    with pytest.raises(KeyError, match="did you mean `width`"):
        batch["wdth"]


def test_a_folder_counts_each_object_once(tmp_path: Path) -> None:
    folder = apg.sample("Mug", n=3).to(tmp_path / "out", "tables")
    counts = json.loads((folder / "manifest.json").read_text())["counts"]
    assert counts["objects"] == 3 and counts["first_valid"] <= 3


def test_arguments_of_mutations_that_would_change_nothing(chests: apg.Samples) -> None:
    for arguments, message in (
        ({"operations": "apa", "strength": 2.0}, "strength applies to the steps of cpa, not to apa"),
        ({"operations": "cpa", "share": 0.2}, "share applies to the templates and counts of apa and dpa, not to cpa"),
        ({"operations": []}, "no operation is given"),
        ({"strength": float("nan")}, "strength is nan"),
        ({"strength": "2"}, "strength is '2'"),
        ({"share": 1.5}, "share is 1.5"),
        ({"variant": 0.5}, "variant is 0.5"),
        ({"one": "width", "only": "lid"}, "one redraws the value that it names, so only cannot be given"),
    ):
        with pytest.raises(UsageError, match=message):
            chests.mutate(**arguments)

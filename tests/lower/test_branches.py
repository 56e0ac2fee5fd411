"""What branches of a ``when`` declare by one name is one value where its types agree, and an error with its places where they do not."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.diagnostics.model import CompileError
from artipg_dsl.session import Session

BODY = """param where : choice here | there
  {root}part body : Cuboid(size = [2cm, 4cm, 6cm])
  when where == here {{ let k = {yes} }} else {{ let k = {no} }}
"""
LID = """part lid : Cuboid(size = [1cm, 1cm, 1cm])
  connect lid to {0}body
  align lid.bottom = {0}k
"""


def program(yes: str, no: str, within: bool) -> str:
    head = "apg 1\nuse primitives { Cuboid }\n"
    if within:
        body = BODY.format(root="", yes=yes, no=no)
        return f"{head}template Chest {{\n  {body}}}\ncategory T {{\n  root part chest : Chest\n  {LID.format('chest.')}}}\n"
    body = BODY.format(root="root ", yes=yes, no=no)
    return f"{head}category T {{\n  {body}  {LID.format('')}}}\n"


UNLIKE = {
    "a plane and a length": ("body.top", "1cm", "a plane", "a length"),
    "a length and a plane": ("1cm", "body.top", "a length", "a plane"),
    "a length and a point": ("1cm", "body.center", "a length", "a point"),
    "an angle and a length": ("30deg", "1cm", "an angle", "a length"),
}


@pytest.mark.parametrize("within", [False, True], ids=["here", "in a template"])
@pytest.mark.parametrize("case", UNLIKE)
def test_types_that_do_not_agree(case: str, within: bool) -> None:
    yes, no, one, other = UNLIKE[case]
    with pytest.raises(CompileError, match=f"k` is {one} in one branch of a `when`, but {other} in another"):
        Session.of_text(program(yes, no, within)).sampler.batch(np.arange(1), 0)


@pytest.mark.parametrize("within", [False, True], ids=["here", "in a template"])
@pytest.mark.parametrize(
    ("yes", "no", "heights"),
    [
        ("body.top", "body.top + 1cm", (0.03, 0.04)),
        ("body.top + 1cm", "body.top", (0.04, 0.03)),
        ("0", "2cm", (0.0, 0.02)),
        ("2", "2cm / 1cm", None),
    ],
)
def test_types_that_agree(yes: str, no: str, heights: tuple[float, float] | None, within: bool) -> None:
    text = program(yes, no, within)
    if heights is None:
        text = text.replace("= k", "= k * 1cm").replace("= chest.k", "= chest.k * 1cm")
        heights = (0.02, 0.02)
    batch = Session.of_text(text).sampler.batch(np.arange(20), 0)
    parts = batch.parts()
    center = parts.translation[[path == "lid" for path in parts.path]][:, 2]
    body = parts.translation[[path.rpartition(".")[2] == "body" for path in parts.path]][:, 2]
    said = [next(v for k, v in batch.drawn(i).items() if k.endswith("where")) for i in range(20)]
    assert set(said) == {"here", "there"}
    assert center - body - 0.005 == pytest.approx([heights[word == "there"] for word in said])


def test_planes_across_different_axes_have_no_coordinate() -> None:
    with pytest.raises(CompileError, match="plane"):
        Session.of_text(program("body.top + 1cm", "body.front + 1cm", False)).sampler.batch(np.arange(1), 0)

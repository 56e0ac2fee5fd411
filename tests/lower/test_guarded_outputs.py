"""What a template hands out under a guard, and which of several statements counts."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.session import Session

from .guarded import HEAD, MADE, MOVING, ROOT, Look, P, material, rows, units, when

HANDED = """role Hold {{ port tip : frame  slot grip  out tall : length }}
template Post : Hold {{
  param a : choice yes | no = yes
  part low : Cuboid(size = [1cm, 1cm, 1cm])
  part high : Cuboid(size = [1cm, 1cm, 1cm])
  align high.bottom = low.top
  when a == yes {{
    port tip = frame(at = low.front.center, out = x, up = z)
    slot grip = low
    let tall = 1cm
  }} else {{
    port tip = frame(at = high.front.center, out = x, up = z)
    slot grip = high
    let tall = 2cm
  }}
}}
category T {{
  {root}  param a : choice yes | no = yes
  part post : Post(a = a)
  connect post.low.bottom on body.top
  part p : Cuboid(size = [1cm, 1cm, post.tall])
  connect p.back to post.tip
  label affordance.lift on post.grip
}}"""


def test_ports_slots_and_outputs_under_a_guard() -> None:
    batch = Session.of_text(HEAD + HANDED.format(root=ROOT)).sampler.batch(np.arange(MADE), seed=2)
    for number, told in enumerate(annotate(batch)):
        parts = {row["name"]: row for row in told["parts"]}
        named = "post.low" if batch.drawn(number)["a"] == "yes" else "post.high"
        assert parts["p"]["center"][2] == pytest.approx(parts[named]["center"][2])
        assert parts["p"]["size"][2] == pytest.approx(0.01 if named == "post.low" else 0.02)
        for name in ("post.low", "post.high"):
            part = sample_points(batch, Sampling(64, per="primitive"))
            row = next(
                k
                for k, owner in enumerate(part.object.tolist())
                if owner == number and batch.program.sites[part.primitive[k, 0]].path == name
            )
            assert (
                part.labels["affordance.lift"][row].all()
                == (name == named)
                == part.labels["affordance.lift"][row].any()
            )


@pytest.mark.parametrize("first", [True, False], ids=["before", "after"])
@pytest.mark.parametrize(
    ("plain_one", "guarded", "look"),
    [
        ("label semantic.lid on p", "label semantic.button on p", rows("parts", "semantic")),
        ("material oak on p", "material steel on p", material),
    ],
    ids=["semantic", "material"],
)
def test_of_equals_the_later_one_counts_where_its_guard_holds(
    plain_one: str, guarded: str, look: Look, first: bool
) -> None:
    said = [plain_one, f"when a == yes {{ {guarded} }}"]
    text = when(MOVING, "", "").removesuffix("}") + "\n".join(said if first else said[::-1]) + "\n}"
    batch = Session.of_text(HEAD + text).sampler.batch(np.arange(MADE), seed=2)
    shown = {truth: look(batch, number, prefix) for number, prefix, truth in units(when, batch)}
    assert (shown[True] != shown[False]) == first


def test_a_limit_in_one_alternative_leaves_the_joint_of_the_other_alone() -> None:
    text = f"""role Lid {{ joint motion  slot p }}
template One : Lid {{ {P}  joint motion : prismatic base -> p along z range 0 .. 5cm  limit motion 0 .. 2cm }}
template Two : Lid {{ {P}  joint motion : prismatic base -> p along z range 0 .. 5cm }}
category T {{
  {ROOT}  part u : Lid = One | Two
  connect u to body
  align u.p.bottom = body.top
}}"""
    batch = Session.of_text(HEAD + text).sampler.batch(np.arange(MADE), seed=2)
    ranges = {batch.drawn(k)["u"]: told["joints"][0]["range"] for k, told in enumerate(annotate(batch))}
    assert ranges == {"One": [0.0, 0.02], "Two": [0.0, 0.05]}


@pytest.mark.parametrize("glass", ["true", "false"])
def test_a_slot_leaves_out_what_an_argument_rules_out(glass: str) -> None:
    text = """role Panel {{ slot skins }}
template Pane : Panel {{
  param glass : bool = true
  part slab : Cuboid(size = [1cm, 1cm, 1cm])
  when glass {{ part face : Cuboid(size = [2mm, 1cm, 1cm])  connect face.bottom on slab.top }}
  when not glass {{ part leaf : Cuboid(size = [5mm, 1cm, 1cm])  connect leaf.bottom on slab.top }}
  slot skins = slab, face, leaf
}}
category T {{
  root part body : Pane(glass = {glass})
  label semantic.lid on body.skins
}}"""
    told = annotate(Session.of_text(HEAD + text.format(glass=glass)).sampler.batch(np.arange(1), seed=2))[0]
    labelled = {row["name"]: row["semantic"] for row in told["parts"]}
    skin = "body.face" if glass == "true" else "body.leaf"
    assert {name: word for name, word in labelled.items() if name != "body"} == {"body.slab": "lid", skin: "lid"}

"""Programs whose statements stand under a guard, in four ways, and what objects show of it: what tests of guards share."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import Points, sample_points
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.runtime.batch import Batch

HEAD = """apg 1
use primitives   { Cuboid, Cylinder }
use materials    { oak, steel }
use vocabularies { semantic, affordance }
role Peg { inherit long : length }
template Square : Peg { part peg : Cuboid(size = [5mm, 5mm, long]) }
template Round : Peg { part peg : Cylinder(radius = 3mm, height = long) }
"""
STAND = "part stand : Cuboid(size = [10cm, 10cm, 10cm])\n"
ROOT = "root part body : Cuboid(size = [4m, 4m, 1cm])\n"
MADE = 12

Look = Callable[[Batch, int, str], Any]
"""What an object shows of the part of it whose names begin with a prefix."""


def when(parts: str, yes: str, no: str, roles: str = "") -> str:
    return f"""category T {{
  {ROOT}  param a : choice yes | no = yes
  {STAND}  connect stand.bottom on body.top at center
  {parts}
  when a == yes {{ {yes} }} else {{ {no} }}
}}"""


def repeat(parts: str, yes: str, no: str, roles: str = "") -> str:
    return f"""category T {{
  {ROOT}  repeat e[i] in 0 ..< 2 {{
    {STAND}    connect stand.bottom on body.top at y = (i - 1/2) * 1m, x = 0
    {parts}
    when i == 0 {{ {yes} }} else {{ {no} }}
  }}
}}"""


def twice(parts: str, yes: str, no: str, roles: str = "") -> str:
    uses = "".join(
        f"  part {name} : Unit(a = {a})\n  connect {name} to body\n  align {name}.stand.bottom = body.top\n"
        f"  align {name}.stand.center.y = {y}\n"
        for name, a, y in (("one", "yes", "-50cm"), ("two", "no", "50cm"))
    )
    return f"""template Unit {{
  param a : choice yes | no = yes
  {STAND}  {parts}
  when a == yes {{ {yes} }} else {{ {no} }}
}}
category T {{
  {ROOT}{uses}}}"""


def role(parts: str, yes: str, no: str, roles: str = "") -> str:
    return f"""role Unit {{ slot stand {roles} }}
template One : Unit {{ {STAND}  {parts}\n {yes}\n }}
template Two : Unit {{ {STAND}  {parts}\n {no}\n }}
category T {{
  {ROOT}  part u : Unit = One | Two
  connect u to body
  align u.stand.bottom = body.top
}}"""


WAYS = [when, repeat, twice, role]


def units(way: Callable[..., str], batch: Batch) -> list[tuple[int, str, bool]]:
    """(object, prefix of its names, whether the first branch holds there)."""
    if way is repeat:
        return [(0, "e[0].", True), (0, "e[1].", False)]
    if way is twice:
        return [(0, "one.", True), (0, "two.", False)]
    drawn = [batch.drawn(k) for k in range(len(batch))]
    if way is role:
        return [(k, "u.", values["u"] == "One") for k, values in enumerate(drawn)]
    return [(k, "", values["a"] == "yes") for k, values in enumerate(drawn)]


def plain(name: str) -> str:
    return name.replace("[", "_").replace("]", "")


def rows(what: str, field: str, key: str = "name") -> Look:
    def look(batch: Batch, number: int, prefix: str) -> Any:
        own = plain(prefix) + "p"
        return [
            row[field] for row in annotate(batch)[number][what] if re.fullmatch(rf"{own}(ull)?", plain(str(row[key])))
        ]

    return look


def names_of(what: str) -> Look:
    return lambda batch, number, prefix: set(rows(what, "name", "link")(batch, number, prefix))


def size(batch: Batch, number: int, prefix: str) -> list[int]:
    """The size along z of each part `q` in millimetres."""
    parts = annotate(batch)[number]["parts"]
    found = [
        p["size"][2] * 1e3 for p in parts if p["name"].startswith(prefix) and p["name"].split(".")[-1].startswith("q")
    ]
    return [round(f) for f in found]


def pool(batch: Batch, number: int, prefix: str) -> tuple[Points, int]:
    """Points, and the row of those that lie on the part `p` of a unit."""
    found = sample_points(batch, Sampling(64, per="primitive"))
    path, element = re.sub(r"\[.\]", "", prefix) + "p", int((re.findall(r"\d", prefix) or [0])[0])
    for row, owner in enumerate(found.object.tolist()):
        site = batch.program.sites[found.primitive[row, 0]].path
        if (owner, site, found.element[row, 0]) == (number, path, element):
            return found, row
    raise AssertionError(path)


def labelled(key: str) -> Look:
    def look(batch: Batch, number: int, prefix: str) -> Any:
        found, row = pool(batch, number, prefix)
        return sorted(set(np.round(found.labels[key][row].astype(float), 6).tolist()))

    return look


def given(key: str) -> Look:
    """What a field says, where it says something."""
    return lambda batch, number, prefix: [v for v in labelled(key)(batch, number, prefix) if v == v]


def material(batch: Batch, number: int, prefix: str) -> Any:
    found, row = pool(batch, number, prefix)
    made = [m.name for m in batch.program.materials.values()]
    return {made[k] for k in found.material[row].tolist()}


def joints(field: str) -> Look:
    return rows("joints", field, "name")


def cm(batch: Batch, number: int, prefix: str) -> list[int]:
    return [round(k / 10) for k in size(batch, number, prefix)]


P = "part p : Cuboid(size = [4cm, 4cm, 4cm])\n"
MOVING = P + "  joint pull : prismatic stand.top -> p.bottom at center gap 1mm range 0 .. 5cm\n"
Q = "part q : Cuboid(size = [1cm, 1cm, {}])\n connect q.bottom on stand.top at center\n"

"""`check` warns of imports that a file does not use, and of values that change no object."""

import pytest

from artipg_dsl.diagnostics import Report
from artipg_dsl.resources import categories_dir, library_dir
from artipg_dsl.semantics.modules import Workspace
from artipg_dsl.semantics.unused import find_imports
from artipg_dsl.session import Session

HEAD = "apg 1\nuse primitives { Cuboid, Cylinder }\nuse vocabularies { semantic, affordance }\n"
USED = "root part body : Cuboid(size = [9cm, 9cm, 9cm])\n  part foot : Cylinder(radius = 1cm, height = 1cm)\n  connect foot.top on body.bottom"


def told(text: str) -> list[str]:
    session = Session.of_text(text, "box.apg")
    session.advise()
    assert not session.report.failed
    return [d.message for d in session.report.diagnostics if d.code == "unused"]


@pytest.mark.parametrize(
    ("body", "names"),
    [
        (USED, []),
        (f"param idle : length in 1cm .. 2cm\n  {USED}", ["idle"]),
        (f"param width : length in 1cm .. 2cm\n  let idle = 2 * width\n  {USED}", ["idle"]),
        (f"param width : length in 1cm .. 2cm\n  require width <= 15mm\n  {USED}", []),
        (f"count idle in 1 .. 3\n  {USED}", ["idle"]),
        (f"{USED}\n  repeat foot_[i] in 0 ..< 2 {{ param idle : length in 1cm .. 2cm }}", ["idle"]),
        (f"param height : length in 1cm .. 2cm\n  {USED}", ["height"]),  # the name of an argument reads nothing
    ],
)
def test_values_that_nothing_reads(body: str, names: list[str]) -> None:
    assert told(f"{HEAD}category Box {{\n  {body}\n}}\n") == [
        f"nothing reads `{name}`: it changes no object" for name in names
    ]


def test_imports_are_told_by_their_line_and_vocabularies_are_not() -> None:
    text = (
        HEAD
        + "use materials { oak, steel, rubber }\ncategory Box { root part body : Cuboid(size = [9cm, 9cm, 9cm]) }\n"
    )
    assert told(text) == [
        "`Cylinder` is imported and not used",
        "`oak`, `steel` and `rubber` are imported and not used",
    ]


def test_a_material_that_nothing_is_made_of() -> None:
    kinds = "".join(f"material {name} {{ density 900kg/m3 }}\n" for name in ("ice", "snow", "slush", "hail"))
    body = f"style look : material = snow | slush\n  {USED}\n  material look on body\n  material hail on foot"
    assert told(f"{HEAD}{kinds}category Box {{\n  {body}\n}}\n") == ["nothing is made of `ice`"]


def test_a_template_may_leave_what_its_role_asks_for_and_be_asked_for_what_it_has() -> None:
    text = """apg 1
use primitives { Cuboid }
role Lid { inherit wide : length }
template Plate : Lid {
  let high = 2cm
  param idle : length in 1cm .. 2cm
  part plate : Cuboid(size = [9cm, 9cm, 1cm])
}
category Box {
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  part lid : Lid(wide = 9cm) = Plate
  connect lid.bottom on body.top
  require lid.high <= 3cm
}
"""
    assert told(text) == ["nothing reads `idle`: it changes no object"]


def test_a_file_without_a_category_is_asked_for_its_imports_alone() -> None:
    text = (
        HEAD
        + "template Plate {\n  param idle : length in 1cm .. 2cm\n  part plate : Cuboid(size = [9cm, 9cm, 1cm])\n}\n"
    )
    assert told(text) == ["`Cylinder` is imported and not used"]


def test_the_shipped_files_use_what_they_import() -> None:
    workspace = Workspace(Report())
    files = [*library_dir().glob("*.apg"), *categories_dir().glob("*.apg")]
    idle = {path.name: names for path in files for names, _ in find_imports(workspace.load_file(path))}
    assert idle == {}


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("let wide(a, b) = 2 * a\n  require wide(1cm, 2cm) < foot.size.x + 3cm", "`wide` does not read `b`"),
        (
            "grasp hold on foot for t in 0 .. 1 { at [0, 0, 0]  approach -x  close y  opening size.y }",
            "the grasp does not read `t`: all of its grasps are the same",
        ),
        ("grasp hold on foot for t in 0 .. 1 { at [0, 0, 0]  approach -x  close y  opening (1 + t) * size.y }", None),
        (
            "grasp hold on foot for t in 0 .. 1 { at [0, 0, 0]  approach -x  close y  opening size.y  stroke t * 1cm }",
            None,
        ),
    ],
)
def test_a_parameter_that_a_formula_ignores(body: str, message: str | None) -> None:
    assert told(f"{HEAD}category Box {{\n  {USED}\n  {body}\n}}\n") == ([] if message is None else [message])


def test_what_stands_beside_a_category_and_is_not_used() -> None:
    shared = """role Foot { slot pad }
role Lid { slot plate }
template Never : Lid { part plate : Cylinder(radius = 1cm, height = 1cm) }
primitive Bar {
  param w : length > 0  test 1cm .. 2cm
  solid = extrude(rectangle(w, w)) along z from 0 to w
}
let double(a) = 2cm
let idle = 2cm
let used = 3cm
"""
    body = f"style pull : Foot = none\n  curve way (t in 0 .. 1) = [t * used, 0mm, 0mm]\n  {USED}"
    assert told(f"{HEAD}{shared}category Box {{\n  {body}\n}}\n") == [
        "nothing uses the template `Never`",
        "nothing uses the primitive `Bar`",
        "nothing uses the function `double`",
        "`double` does not read `a`",
        "nothing uses the value `idle`",
        "nothing reads `pull`: it changes no object",
        "nothing reads `way`: it changes no object",
    ]

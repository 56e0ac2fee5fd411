"""Modules: where `use` looks, what it brings in, and what it refuses."""

from artipg_dsl.semantics.symbols import is_a, members, parent_of

from .helpers import check_text, codes

LID = "apg 1\nuse primitives { Cuboid }\n"


def test_a_module_beside_the_file_comes_before_the_library(tmp_path):
    own = "apg 1\nrole Handle { slot knob }\n"
    report, typed = check_text(tmp_path, "apg 1\nuse handles { Handle }\nlet own = 1\n", handles=own)
    assert codes(report) == []
    assert typed.main.find("Handle").module.source.name == str(tmp_path / "handles.apg")


def test_the_library_is_found_and_named_without_its_folder(tmp_path):
    report, typed = check_text(tmp_path, "apg 1\nuse handles { Handle }\nlet own = 1\n")
    assert codes(report) == []
    assert typed.main.find("Handle").module.source.name == "library/handles.apg"


def test_a_symbol_is_the_same_object_in_every_scope(tmp_path):
    a = "apg 1\nuse b { R }\ntemplate T : R { }\n"
    report, typed = check_text(tmp_path, "apg 1\nuse a { T }\nuse b { R }\nlet own = 1\n", a=a, b="apg 1\nrole R { }\n")
    assert codes(report) == []
    assert parent_of(typed.main.find("T")) is typed.main.find("R")


def test_a_cycle_is_reported_once_and_named_whole(tmp_path):
    ring = {"a": "b", "b": "c", "c": "a"}
    texts = {m: f"apg 1\nuse {n} {{ {n.upper()} }}\nrole {m.upper()} {{ }}\n" for m, n in ring.items()}
    report, _ = check_text(tmp_path, "apg 1\nuse a { A }\n", **texts)
    (found,) = [d for d in report.diagnostics if d.code == "import-cycle"]
    assert found.message == "modules use each other in a circle: a -> b -> c -> a"
    assert [text for _, text in found.notes] == ["`a` uses `b`", "`b` uses `c`"]


def test_imports_are_not_handed_on(tmp_path):
    report, _ = check_text(tmp_path, "apg 1\nuse bodies { Cuboid }\n")
    (found,) = report.diagnostics
    assert found.code == "unknown-import"
    assert found.hint == "`bodies` uses it too: write `use primitives { Cuboid }`"


def test_two_imports_of_one_name_clash(tmp_path):
    report, _ = check_text(
        tmp_path, "apg 1\nuse a { R }\nuse b { R }\n", a="apg 1\nrole R { }\n", b="apg 1\nrole R { }\n"
    )
    assert codes(report) == ["duplicate-name"]


ROLES = """apg 1
use primitives { Cuboid }
role Front { inherit size : length[3]  param panel : length in 1cm .. 2cm }
role Closed : Front { slot leaf  out mouth : length }
template Drawer : Closed {
  param panel : length in 1cm .. 3cm
  part leaf : Cuboid(size = size)
  let mouth = panel
}
"""


def test_roles_are_inherited_and_refined(tmp_path):
    report, typed = check_text(tmp_path, ROLES)
    assert codes(report) == []
    front, closed, drawer = (typed.main.find(n) for n in ("Front", "Closed", "Drawer"))
    assert is_a(drawer, closed) and is_a(drawer, front) and is_a(closed, front)
    assert not is_a(front, closed) and not is_a(closed, drawer)


def test_members_of_a_template_take_over_role_parameters(tmp_path):
    _, typed = check_text(tmp_path, ROLES)

    def names(symbol):
        return [n for s in members(symbol) for n in (getattr(s, "names", None) or (s.name,))]

    assert names(typed.main.find("Closed")) == ["size", "panel", "leaf", "mouth"]
    assert names(typed.main.find("Drawer")) == ["size", "panel", "leaf", "mouth"]  # `panel` and `mouth` are its own
    panel = next(s for s in members(typed.main.find("Drawer")) if getattr(s, "names", ()) == ("panel",))
    assert panel in typed.main.find("Drawer").body


def test_a_failed_import_is_not_reported_again_where_its_names_are_used(tmp_path):
    text = (
        "apg 1\nuse handels { Handle, BarHandle }\nuse primitives { Cuboit }\nuse materials { stel }\n"
        "category Chest {\n  root part body : Cuboit(size = [1cm, 1cm, 1cm])\n  part pull : Handle = BarHandle | none\n"
        "  connect pull.mount to body.front\n  material stel on body\n  when pull is BarHandle { }\n}\n"
    )
    report, _ = check_text(tmp_path, text)
    assert [(d.code, d.span.line) for d in report.diagnostics] == [
        ("unknown-module", 2),
        ("unknown-import", 3),
        ("unknown-import", 4),
    ]

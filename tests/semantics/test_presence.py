"""What a template or an element of a repeat declares under a guard is named from outside only where the guard holds."""

from __future__ import annotations

from pathlib import Path

import pytest

from .helpers import HEAD, check_text

UNIT = """role Stand {{ port foot : frame }}
template Inner {{ param b : choice one | two = one  part stem : Cuboid(size = [1cm, 1cm, 1cm])
  when b == one {{ let k = 3cm }} }}
template U : Stand {{
  param a : choice yes | no = yes
  count m in 1 .. 3
  part stem : Cuboid(size = [2cm, 2cm, 20cm])
  part inner : Inner(b = one)
  part free : Inner
  {said}
  port foot = frame(at = stem.bottom.center, out = -z, up = x)
}}
template V : Stand {{
  param a : choice yes | no = yes
  part stem : Cuboid(size = [2cm, 2cm, 20cm])
  let k = 1cm
  port foot = frame(at = stem.bottom.center, out = -z, up = x)
}}
"""
FRAME = "frame(at = stem.top.center, out = z, up = x)"
KINDS = {
    "let": ("let k = 3cm", "require {} < 1m", "u.k"),
    "param": ("param k : length in 1cm .. 2cm", "require {} < 1m", "u.k"),
    "count": ("count k in 1 .. 2", "require {} < 9", "u.k"),
    "flag": ("let k = m == 1", "require {}", "u.k"),
    "port": (f"port tip = {FRAME}", "part q : Cuboid(size = [1cm, 1cm, 1cm])\n  connect q.bottom to {}", "u.tip"),
    "indexed port": (
        f"port tip[0] = {FRAME}",
        "part q : Cuboid(size = [1cm, 1cm, 1cm])\n  connect q.bottom to {}",
        "u.tip[0]",
    ),
    "box": ("port k : box = inner.box", "require {}.size.x < 1m", "u.k"),
    "part": ("part k : Cuboid(size = [1cm, 1cm, 1cm])", "align body.top = {}.bottom", "u.k"),
    "repeat": (
        "repeat e[i] in 0 ..< m { part d : Cuboid(size = [1cm, 1cm, 1cm]) }",
        "require {}[0].d.size.x < 1m",
        "u.e",
    ),
}


def errors(folder: Path, said: str, body: str, part: str = "part u : U") -> list[str]:
    text = f"""{HEAD}use vocabularies {{ semantic }}
{UNIT.format(said=said)}
category T {{
  root part body : Cuboid(size = [1m, 1m, 1cm])
  param c : choice yes | no = yes
  count n in 2 .. 4
  {part}
  {"" if "connect u" in body else "connect u.foot to body.top"}
  {body}
}}
"""
    report, _ = check_text(folder, text)
    found = [d for d in report.diagnostics if d.severity == "error"]
    assert {d.code for d in found} <= {"optional-outside-when"}, [d.message for d in found]
    return [d.message for d in found]


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_template_has_under_a_guard_needs_the_guard(tmp_path: Path, kind: str) -> None:
    declared, use, name = KINDS[kind]
    use = use.format(name)
    (message, *_) = errors(tmp_path, f"when a == yes {{ {declared} }}", use)
    assert message.startswith(f"`{name}` only exists under a guard")
    assert errors(tmp_path, f"when a == yes {{ {declared} }}", f"when u.a == no {{ {use} }}") != []
    assert errors(tmp_path, f"when a == yes {{ {declared} }}", f"when u.a == yes {{ {use} }}") == []
    assert errors(tmp_path, f"when a == yes {{ }} else {{ {declared} }}", f"when u.a == no {{ {use} }}") == []
    assert errors(tmp_path, declared, use) == []


def test_a_port_that_may_be_absent_connects_nothing(tmp_path: Path) -> None:
    said = f"when a == yes {{ port tip = {FRAME} }}"
    (message,) = errors(tmp_path, said, "connect u.tip to body.top")
    assert message.startswith("`u.tip` only exists under a guard")
    both = "when u.a == yes { connect u.tip to body.top } else { connect u.foot to body.top }"
    assert errors(tmp_path, said, both) == []


def test_where_it_is_declared_and_how_it_is_asked_for(tmp_path: Path) -> None:
    text = f"{HEAD}{UNIT.format(said='when a == yes and m > 1 { let k = 1cm }')}category T {{\n  root part u : U\n  require u.k < 1m\n}}\n"
    report, _ = check_text(tmp_path, text)
    (found,) = (d for d in report.diagnostics if d.code == "optional-outside-when")
    assert found.message == "`u.k` only exists under a guard: it is declared in line 13 under `when a == yes and m > 1`"
    assert (
        found.hint == "put this inside `when u.a == yes and u.m > 1 { }`, or declare `k` in every branch of the `when`"
    )


@pytest.mark.parametrize(
    ("said", "body", "part", "fine"),
    [
        ("when a == yes { let k = 1cm } else { let k = 2cm }", "require u.k < 1m", "part u : U", True),
        ("when a == yes { let k = 1cm }", "require u.k < 1m", "part u : U(a = yes)", True),
        ("when a == yes { let k = 1cm }", "require u.k < 1m", "part u : U(a = no)", False),
        ("when a == yes { let k = 1cm }", "when c == yes { require u.k < 1m }", "part u : U(a = c)", True),
        ("when a == yes { let k = 1cm }", "when c == no { require u.k < 1m }", "part u : U(a = c)", False),
        ("when m > 1 { let k = 1cm }", "require u.k < 1m", "part u : U(m = 3)", True),
        ("when m > 1 { let k = 1cm }", "require u.k < 1m", "part u : U(m = 1)", False),
        ("", "require u.inner.k < 1m", "part u : U", True),
        ("", "require u.free.k < 1m", "part u : U", False),
        ("", "when u.free.b == one { require u.free.k < 1m }", "part u : U", True),
        ("when a == yes { let k = 1cm }", "require u.k < 1m", "part u : Stand = U | V", False),
        ("when a == yes { let k = 1cm }", "when u.a == yes { require u.k < 1m }", "part u : Stand = U | V", True),
        ("when a == yes { let k = 1cm }", "when u is V { require u.k < 1m }", "part u : Stand = U | V", True),
        ("when a == yes { let k = 1cm }", "require u.k < 1m", "part u : Stand = U(a = yes) | V", True),
        (
            "when a == yes { let k = 1cm  part d : Cuboid(size = [k, k, k]) }",
            "when u.d { require u.k < 1m }",
            "part u : U",
            True,
        ),
        (
            "when a == yes { let k = 1cm  part d : Cuboid(size = [k, k, k]) }",
            "when u.a == yes { require u.d.size.x < 1m }",
            "part u : U",
            True,
        ),
        ("when a == yes { when m > 1 { let k = 1cm } }", "when u.a == yes { require u.k < 1m }", "part u : U", False),
        (
            "when a == yes { when m > 1 { let k = 1cm } }",
            "when u.m > 2 and u.a == yes { require u.k < 1m }",
            "part u : U",
            True,
        ),
    ],
)
def test_what_is_known_of_the_instance_counts(tmp_path: Path, said: str, body: str, part: str, fine: bool) -> None:
    assert (errors(tmp_path, said, body, part) == []) == fine


@pytest.mark.parametrize(
    ("guard", "use", "fine"),
    [
        ("i == 0", "require e[0].k < 1m", True),
        ("i == 0", "require e[1].k < 1m", False),
        ("i == 0", "require e[last].k < 1m", False),
        ("i == n - 1", "require e[last].k < 1m", True),
        ("n - 1 > i", "require e[last].k < 1m", False),
        ("i == 0", "require e[0].q.size.x < 1m", True),
        ("i == 0", "require e[1].q.size.x < 1m", False),
        ("i == 0", "require min(e.k) < 1m", False),
        ("i == 0", "require min(e.q.size.x) < 1m", False),
        ("i >= 0", "require min(e.k) < 1m", True),
        ("c == yes", "when c == yes { require min(e.k) < 1m }", True),
        ("i == 0", "label semantic.lid on e.q", True),
    ],
)
def test_elements_of_a_repeat(tmp_path: Path, guard: str, use: str, fine: bool) -> None:
    body = f"""repeat e[i] in 0 ..< n {{
    when {guard} {{ param k : length in 1cm .. 2cm  part q : Cuboid(size = [k, k, k])  connect q to body }}
  }}
  {use}"""
    assert (errors(tmp_path, "", body) == []) == fine


@pytest.mark.parametrize(
    ("guard", "use", "fine"),
    [("i == 0", "i == 1", True), ("i == 0", "i > 1", False), ("i != 2", "i > 0", False), ("i < 2", "i == 2", True)],
)
def test_the_element_before(tmp_path: Path, guard: str, use: str, fine: bool) -> None:
    body = f"repeat e[i] in 0 ..< n {{ when {guard} {{ let k = 1cm }}\n    when {use} {{ let w = previous.k }} }}"
    assert (errors(tmp_path, "", body) == []) == fine

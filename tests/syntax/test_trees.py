"""A tree is kept as data and comes back as it was; what is no tree of the text is refused."""

import json
import random
from pathlib import Path

import pytest

from artipg_dsl import cache
from artipg_dsl.diagnostics import CompileError, Report
from artipg_dsl.resources import library_dir
from artipg_dsl.source import Source
from artipg_dsl.syntax import ast, trees
from artipg_dsl.syntax.data import from_data, to_data
from artipg_dsl.syntax.grammar import Machine
from artipg_dsl.syntax.parse import parse
from artipg_dsl.syntax.walk import walk

FORMS = Path(__file__).parent / "design" / "forms.apg"


def read(path):
    return Source(path.name, path.read_text(encoding="utf-8"))


def places(tree):
    """Which nodes are one and the same."""
    numbers = {}
    return [numbers.setdefault(id(node), len(numbers)) for node in walk(tree)]


@pytest.mark.some
@pytest.mark.parametrize("path", [FORMS, *sorted(library_dir().glob("[m-t]*.apg"))], ids=lambda path: path.stem)
def test_a_tree_comes_back_as_it_was(path):
    source = read(path)
    tree = parse(source, Report())
    again = from_data(json.loads(json.dumps(to_data(tree))), source, ast.Module)
    assert again == tree and repr(again) == repr(tree) and places(again) == places(tree)
    assert {type(node) for node in walk(again)} == {type(node) for node in walk(tree)}
    if path is not FORMS:
        assert trees._scanned(source).whole == tree


def test_what_is_no_tree_is_refused():
    """One place of the data is changed at a time: it is refused with one of a few errors, or is a tree of the grammar's nodes."""
    source = read(FORMS)
    rows = to_data(parse(source, Report()))
    pick = random.Random(7)
    refused = 0
    for _ in range(400):
        spoilt = json.loads(json.dumps(rows))
        row = pick.choice(spoilt)
        row[pick.randrange(len(row))] = pick.choice([-1, 0, 3, 10**9, "x", None, 1.5, True, [], [0], [[0, 1]], {}])
        try:
            tree = from_data(spoilt, source, ast.Module)
        except (ValueError, TypeError, IndexError):
            refused += 1
            continue
        for node in walk(tree):
            assert 0 <= node.span.start <= node.span.end <= len(source.text)
            if isinstance(node, ast.BinaryExpr):
                assert isinstance(node.left, ast.Expr) and isinstance(node.op, str)
    assert refused > 200


def test_a_file_is_parsed_once_for_all_processes(tmp_path, monkeypatch):
    monkeypatch.setenv("APGC_CACHE", str(tmp_path))
    parsed = []
    tree = Machine.tree
    monkeypatch.setattr(Machine, "tree", lambda self, source, text: parsed.append(text) or tree(self, source, text))
    sources = [Source("a.apg", "apg 1\nmaterial oak { density 700kg/m3 }\n"), Source("b.apg", "apg 1\nlet two = 2\n")]

    def anew():
        monkeypatch.setattr(trees, "_trees", {})
        parsed.clear()
        found = [trees.tree_of(source, Report()).whole for source in sources]
        return found, len(parsed)

    first, number = anew()
    assert number == 2 and anew() == (first, 0)
    sources[1] = Source("b.apg", "apg 1\nlet two = 3\n")
    assert anew()[1] == 1
    for path in tmp_path.glob("tree-*"):
        cache.write(path.name, b"[[0, 0, 0]]")
    assert anew()[1] == 2 and anew()[1] == 0


def test_of_a_kept_tree_what_is_asked_for_is_made(tmp_path, monkeypatch):
    monkeypatch.setenv("APGC_CACHE", str(tmp_path))
    made = []
    from_rows = trees.from_data
    monkeypatch.setattr(trees, "from_data", lambda rows, *more: made.append(len(rows)) or from_rows(rows, *more))
    source = read(library_dir() / "handles.apg")
    parsed = trees._parsed(source, Report())
    kept = trees._recalled(source)
    assert len(made) == 1 and kept.heads == parsed.heads and kept.uses == parsed.uses and kept.span == parsed.span
    number = len(kept.heads) // 2
    assert kept.declaration(number) == parsed.declarations[number] and len(made) == 2
    assert kept.declaration(number) is kept.declaration(number) and len(made) == 2
    assert kept.whole == parsed and kept.whole.declarations[number] is kept.declaration(number)
    assert len(made) == 1 + len(kept.heads)


def test_what_is_used_of_a_shipped_file_is_parsed(tmp_path, monkeypatch):
    monkeypatch.setenv("APGC_CACHE", str(tmp_path))
    monkeypatch.setattr(trees, "_trees", {})
    text = "apg 1\n# of wood\n\n## Hard.\nmaterial oak { density 700kg/m3 }  ## brown\n\nlet two = 2\n\nmaterial pine { density 500kg/m3 }\n"
    source = Source("a.apg", text)
    parsed = parse(source, Report())
    tree = trees.shipped_tree(source, Report())
    assert tree.heads == parsed.heads and tree.declaration(0).doc == parsed.declarations[0].doc == "Hard.\nbrown"
    trees.keep_parsed()
    kept = trees._recalled(source)
    assert not kept.complete and kept.declaration(0) == tree.declaration(0) and not kept.parsed
    assert trees.tree_of(source, Report()).whole == parsed and trees._recalled(source).complete

    wrong = Source("b.apg", text.replace("let two = 2", "let two = "))
    tree = trees.shipped_tree(wrong, Report())
    assert tree.declaration(0).name == "oak" and tree.declaration(2).name == "pine"
    with pytest.raises(CompileError, match="syntax"):
        tree.declaration(1)
    report = Report()
    assert trees.tree_of(wrong, report) is None and report.failed
    for unusual in ("  material oak { density 700kg/m3 }\n", "let one = 1\nuse wood { oak }\n"):
        assert isinstance(trees.shipped_tree(Source("c.apg", unusual), Report()), ast.Module)


def test_a_spoilt_declaration_is_parsed(tmp_path, monkeypatch):
    """One that is no tree, that of another name or class, and a head that is none."""
    monkeypatch.setenv("APGC_CACHE", str(tmp_path))
    source = read(library_dir() / "handles.apg")
    parsed = trees._parsed(source, Report())
    entry = trees._entry(source)
    head, *rows = cache.read(entry).split(b"\n")
    first, other = (
        next(n for n, h in enumerate(parsed.heads) if h.kind is kind) for kind in (ast.RoleDecl, ast.TemplateDecl)
    )
    for spoilt in (b"[[0,0,0]]", b"[]", b"no", rows[first + 1], rows[other]):
        cache.write(entry, b"\n".join([head, *rows[:first], spoilt, *rows[first + 1 :]]))
        kept = trees._recalled(source)
        assert isinstance(kept, trees.KeptTree) and kept.declaration(first) == parsed.declarations[first]
        assert cache.read(entry) == b"\n".join([head, *rows]) and kept.whole == parsed
    module, heads = json.loads(head)
    for wrong in ([10**6, *heads[0][1:]], [heads[0][0], "Other", *heads[0][2:]], [*heads[0][:2], -4, -1], []):
        cache.write(entry, b"\n".join([json.dumps([module, [wrong, *heads[1:]]]).encode(), *rows]))
        assert trees._recalled(source) is None and cache.read(entry) is None
    for lines in ([head, *rows[1:]], [b"[]", *rows]):
        cache.write(entry, b"\n".join(lines))
        assert trees._recalled(source) is None

"""The house: an import inside a function says why it stands there, and no files go round in circles.

Arrows between rooms, and between files of which none imports inside a function, are held by ``lint-imports``.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

from artipg_dsl.garbage import uncollected

ROOT = Path(__file__).parents[1] / "artipg_dsl"
REASONS = ("start-up", "extra")
INDENTED = re.compile(r"^[ \t].*\bimport\b", re.MULTILINE)
IGNORED = 11  # places where the type checker is told to look away
START = ("cli", "api", "__init__.py", "session.py")  # they load what a command needs, and nothing else


@pytest.fixture(scope="module", autouse=True)
def kept() -> Iterator[None]:
    """More than a million nodes are made here, and all are kept to the end."""
    with uncollected():
        yield
        nodes.cache_clear()
        parsed.cache_clear()


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes(tree: ast.Module) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(tree))


def late_imports(path: Path) -> Iterator[tuple[int, str]]:
    """Line and text of every import of our own modules inside a function."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    for function in nodes(parsed(path)) if INDENTED.search(text) else ():
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            if not any(INDENTED.match(line) for line in lines[function.lineno - 1 : function.end_lineno]):
                continue
            for node in ast.walk(function):
                if isinstance(node, ast.ImportFrom) and node.level:
                    yield node.lineno, lines[node.lineno - 1].strip()


def test_imports_inside_functions_say_why() -> None:
    silent = [
        f"{path.relative_to(ROOT)}:{line}: {text}"
        for path in sorted(ROOT.rglob("*.py"))
        if path.relative_to(ROOT).parts[0] not in START
        for line, text in late_imports(path)
        if text.partition("# ")[2].partition(":")[0] not in REASONS
    ]
    assert not silent


def for_types(node: ast.AST) -> bool:
    """``if TYPE_CHECKING``: what stands in it is never imported."""
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def imported(node: ast.AST, package: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """What may be a module of ours among what is imported below a node of a file of ``package``, inside functions too."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ImportFrom) and child.level:
            base = (*package[: len(package) - child.level + 1], *(child.module.split(".") if child.module else ()))
            yield base
            yield from ((*base, alias.name) for alias in child.names)
        elif for_types(child):
            yield from (found for other in child.orelse for found in imported(ast.Module([other], []), package))
        else:
            yield from imported(child, package)


def imports(root: Path) -> dict[str, set[str]]:
    """Every module below a folder and which others of them it imports, named by their paths."""
    files = {path.relative_to(root).with_suffix("").parts: path for path in root.rglob("*.py")}
    found: dict[str, set[str]] = {}
    for name, path in files.items():
        tree = parsed(path)
        targets = {t for t in imported(tree, name[:-1]) if t in files and t != name}
        found["/".join(name)] = {"/".join(t) for t in targets}
    return found


def circles(edges: Mapping[str, set[str]]) -> list[set[str]]:
    """The strongly connected components of more than one module (Tarjan)."""
    number: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[set[str]] = []

    def visit(node: str) -> None:
        number[node] = low[node] = len(number)
        stack.append(node)
        for other in sorted(edges[node]):
            if other not in number:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] == number[node]:
            at = stack.index(node)
            if len(stack) - at > 1:
                found.append(set(stack[at:]))
            del stack[at:]

    for node in sorted(edges):
        if node not in number:
            visit(node)
    return found


def test_circles_are_found() -> None:
    edges = {"a/x": {"a/y"}, "a/y": {"a/z", "b/w"}, "a/z": {"a/x"}, "b/w": set(), "b/v": {"b/w"}}
    assert circles(edges) == [{"a/x", "a/y", "a/z"}]


def test_imports_are_read_as_python_does(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "x.py").write_text(
        "from . import y\nfrom ..b import name\nif TYPE_CHECKING:\n    from . import z\ndef f():\n    from .w import g\n"
    )
    for name in ("a/y", "a/z", "a/w", "b"):
        (tmp_path / f"{name}.py").write_text("")
    assert imports(tmp_path)["a/x"] == {"a/y", "a/w", "b"}


def test_no_files_import_one_another_in_a_circle() -> None:
    edges = imports(ROOT)
    assert sum(map(len, edges.values())) > 1000  # the files have been read
    assert not circles(edges)


def test_the_type_checker_looks_away_seldom() -> None:
    assert sum(path.read_text(encoding="utf-8").count("# type: ignore") for path in ROOT.rglob("*.py")) <= IGNORED


def test_one_formatter_lays_out_every_line() -> None:
    files = [path for top in ("artipg_dsl", "benchmarks") for path in sorted((ROOT.parent / top).rglob("*.py"))]
    assert len(files) > 400
    assert not [path for path in files if "# fmt:" in path.read_text(encoding="utf-8")]


def test_lowering_asks_no_value_for_an_attribute_by_its_name() -> None:
    """What a value is of is asked of its class."""
    asked = {"getattr", "hasattr"}
    for path in (ROOT / "lower").rglob("*.py"):
        tree = parsed(path)
        assert not asked & {node.id for node in nodes(tree) if isinstance(node, ast.Name)}, path


CALLED_BY_TEXT = ("runtime/kernels", "runtime/draws")  # what generated code calls


def defined(tree: ast.Module) -> set[str]:
    """The functions, classes and constants of a file that have no underscore in front."""
    names = {node.name for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    for node in tree.body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return {name for name in names if not name.startswith("_")}


def asked_for(tree: ast.Module) -> set[str]:
    """Names that a file may take from others: what it imports, attributes, and what follows a colon in its texts."""
    names: set[str] = set()
    for node in nodes(tree):
        if isinstance(node, ast.ImportFrom):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Attribute):
            names.add(node.attr)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names.add(node.value.rpartition(":")[2])
    return names


def asked_of(node: ast.Assign) -> bool:
    """Whether others may ask for what is assigned."""
    return all(isinstance(target, ast.Name) and not target.id.startswith("_") for target in node.targets)


def annotated(tree: ast.Module) -> set[str]:
    """Names in the annotations, bases and public tables of a file: what others are handed does not stay inside."""
    places: list[ast.expr | None] = []
    for node in nodes(tree):
        if isinstance(node, ast.FunctionDef):
            places.append(node.returns)
        elif isinstance(node, ast.arg | ast.AnnAssign):
            places.append(node.annotation)
        elif isinstance(node, ast.ClassDef):
            places += node.bases
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple | ast.Dict) and asked_of(node):
            places.append(node.value)
    return {name.id for place in places if place for name in ast.walk(place) if isinstance(name, ast.Name)}


def test_what_stays_inside_a_file_has_an_underscore() -> None:
    folders = (ROOT, ROOT.parent / "tests", ROOT.parent / "benchmarks")
    trees = {path: parsed(path) for top in folders for path in top.rglob("*.py")}
    asked = {path: asked_for(tree) for path, tree in trees.items()}
    often = Counter(name for names in asked.values() for name in names)
    wrong = []
    for path in sorted(ROOT.rglob("*.py")):
        module = path.relative_to(ROOT).with_suffix("").as_posix()
        if module not in CALLED_BY_TEXT:
            inside = {name for name in defined(trees[path]) if often[name] == (name in asked[path])}
            wrong += [f"{module}: {name}" for name in inside - annotated(trees[path])]
    assert not wrong

"""What is kept between runs changes nothing but time: the same bytes and findings, whatever becomes of its files."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl import cache, solids
from artipg_dsl.cli.main import main
from artipg_dsl.geometry import density, facts, flat, pieces, quadrature, topology
from artipg_dsl.geometry.patches import surfaces
from artipg_dsl.geometry.trial import variants
from artipg_dsl.graph.program import Program
from artipg_dsl.graph.writing import digest, to_text
from artipg_dsl.resources import categories_dir
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session
from artipg_dsl.syntax import ast, trees

PROGRAM = """apg 1
use primitives { Cylinder }
use feet { Foot }
category Stool {
  param tall : length in 40cm .. 60cm = 50cm
  root part seat : Cylinder(radius = 20cm, height = 3cm)
  part foot : Foot(tall = tall)
  connect foot.top on seat.bottom
}
"""
FEET = """apg 1
use primitives { Cylinder }
template Foot {
  param tall : length
  part leg : Cylinder(radius = 3cm, height = tall)
}
"""


@pytest.fixture
def kept(tmp_path, monkeypatch):
    monkeypatch.setenv("APGC_CACHE", str(tmp_path / "kept"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    monkeypatch.setattr(trees, "_trees", {})
    return tmp_path / "kept"


@pytest.fixture
def stool(tmp_path):
    (tmp_path / "feet.apg").write_text(FEET)
    path = tmp_path / "stool.apg"
    path.write_text(PROGRAM)
    return path


def computed(session):
    return "typed" in session.__dict__


def found(path):
    session = Session.of(path)
    return [repr(d) for d in session.examine().diagnostics], computed(session)


def test_findings_are_kept_and_shown_again(kept, stool, capsys):
    first = found(stool)
    assert first[1] and any("warning" in text for text in first[0])
    assert found(stool) == (first[0], False)
    assert main(["check", str(stool)]) == 0
    shown = capsys.readouterr()
    os.environ["APGC_CACHE"] = "off"
    assert main(["check", str(stool)]) == 0
    assert capsys.readouterr() == shown


@pytest.mark.parametrize("end", ["\r", "\r\n"])
def test_modules_with_line_ends_of_other_systems_are_known_again(kept, stool, end):
    (stool.parent / "feet.apg").write_bytes(b"\xef\xbb\xbf" + FEET.replace("\n", end).encode())
    first = found(stool)
    assert first[1] and found(stool) == (first[0], False)


def test_errors_are_kept_too(kept, stool):
    stool.write_text(PROGRAM.replace("tall = tall", "tell = tall"))
    first = found(stool)
    assert any("error" in text for text in first[0])
    assert found(stool) == (first[0], False)


def test_a_kept_program_is_the_same(kept, stool):
    session = Session.of(stool)
    text = to_text(session.sampler.program)
    again = Session.of(stool)
    assert to_text(again.sampler.program) == text and not computed(again)
    assert again.sampler.program.hash == session.sampler.program.hash and not again.sampler.program.foreign


@pytest.mark.parametrize("change", ["text", "import", "import removed", "nearer module", "compiler"])
def test_what_an_entry_follows_from_is_looked_at(kept, stool, monkeypatch, change):
    found(stool)
    if change == "text":
        stool.write_text(PROGRAM.replace("20cm", "21cm"))
    elif change == "import":
        (stool.parent / "feet.apg").write_text(FEET.replace("3cm", "4cm"))
    elif change == "import removed":
        (stool.parent / "feet.apg").unlink()
    elif change == "nearer module":
        (stool.parent / "primitives.apg").write_text("apg 1\n")
    else:
        monkeypatch.setattr(cache, "stamp", lambda: "another")
    assert found(stool)[1]


def test_an_edit_reads_again_what_changed_alone(kept, stool, monkeypatch):
    """Of one number, then of an imported template: the findings are those found without anything kept."""
    found(stool)
    parsed, read = [], []
    tree, recalled = trees._parsed, trees.from_data
    monkeypatch.setattr(trees, "_parsed", lambda source, report: parsed.append(source.name) or tree(source, report))
    monkeypatch.setattr(
        trees, "from_data", lambda rows, source, kind: read.append(kind) or recalled(rows, source, kind)
    )
    feet = stool.parent / "feet.apg"
    for path, text in ((stool, PROGRAM.replace("50cm", "55cm")), (feet, FEET.replace("3cm", "4cm"))):
        path.write_text(text)
        for held in (parsed, read, trees._trees):
            held.clear()
        kept_findings = found(stool)
        assert [Path(name).name for name in parsed] == [path.name] and kept_findings[1]
        # Cylinder of the library; the feet or the stool
        assert read.count(ast.PrimitiveDecl) == 1 and len(read) == read.count(ast.Module) + 2
        monkeypatch.setenv("APGC_CACHE", "off")
        trees._trees.clear()
        assert found(stool) == kept_findings
        monkeypatch.setenv("APGC_CACHE", str(kept))


def test_files_that_are_spoilt_cut_short_or_false_count_for_nothing(kept, stool):
    first = found(stool)[0]
    for spoil in (
        lambda _, data: data[:-1] + b"?",
        lambda _, data: data[: len(data) // 2],
        lambda _, data: b"",
        lambda _, data: cache.sealed("another", data[len(cache.MARK) + cache.SEAL :]),
        lambda name, _: cache.sealed(name, b"{}\n"),
        lambda name, _: cache.sealed(name, b"\xff"),
        lambda *of: sealed(*of, lambda held: held.update(findings=[["no-code", "x", None, "error", None, [], []]])),
        lambda *of: sealed(*of, lambda held: held["findings"][0].__setitem__(2, [0, 5, 10**9])),
        lambda *of: sealed(*of, lambda held: held["findings"][0].__setitem__(5, [[[7, 0, 1], "x"]])),
        lambda *of: sealed(*of, lambda held: held.update(absent=["a" * 5000])),
    ):
        for path in kept.glob("[!ts]*"):  # trees and solids have tests of their own
            path.write_bytes(spoil(path.name, path.read_bytes()))
        assert found(stool) == (first, True)
        assert found(stool) == (first, False)  # written again


def sealed(name, data, change):
    head, _, rest = data[len(cache.MARK) + cache.SEAL :].partition(b"\n")
    held = json.loads(head)
    if not held.get("findings"):
        held["findings"] = [["unplaced", "x", [0, 0, 1], "warning", None, [], []]]
    change(held)
    body = json.dumps(held).encode() + b"\n" + rest
    return cache.sealed(name, body)


def test_a_program_in_an_entry_is_verified(kept, stool):
    text = to_text(Session.of(stool).sampler.program)
    for path in kept.glob("program-*"):
        data = (
            path.read_bytes()[len(cache.MARK) + cache.SEAL :]
            .replace(b'"real"', b'"evil"')
            .replace(b"= real", b"= evil")
        )
        path.write_bytes(cache.sealed(path.name, data))
    again = Session.of(stool)
    assert to_text(again.sampler.program) == text and computed(again)


def test_what_is_kept_with_a_program_is_what_would_be_found(kept, stool):
    made = Session.of(stool).sampler.program
    read = Session.of(stool).sampler.program
    assert read.hash == made.hash == digest(read)
    told = [facts._told.get(primitive) for primitive in read.primitives.values()]
    assert told == [facts.digest_of(primitive) for primitive in made.primitives.values()]
    assert told == [digest(Program("", primitives={p.name: p})) for p in read.primitives.values()]


def test_nothing_is_kept_when_off_or_where_nothing_can_be_written(tmp_path, stool, monkeypatch, capsys):
    monkeypatch.setattr(cache, "_told", False)
    monkeypatch.setenv("APGC_CACHE", "off")
    found(stool)
    assert cache.folder() is None and found(stool)[1]
    (tmp_path / "file").write_text("")
    assert capsys.readouterr().err == ""
    monkeypatch.setenv("APGC_CACHE", str(tmp_path / "file"))
    assert found(stool)[1] and found(stool)[1]
    assert capsys.readouterr().err == f"nothing is kept in {tmp_path / 'file'}, which APGC_CACHE names: File exists\n"
    assert (tmp_path / "file").read_text() == ""
    cache.write("entry", b"")
    assert capsys.readouterr().err == ""  # it has been said


def test_the_oldest_go_first(kept):
    kept.mkdir()
    for number in range(10):
        path = kept / f"check-{number}"
        path.write_bytes(b"x" * 100)
        os.utime(path, (number, number))
    cache.prune(kept, 500)
    assert sorted(path.name for path in kept.iterdir()) == ["check-7", "check-8", "check-9"]
    (kept / ".left.partial").write_bytes(b"")
    os.utime(kept / ".left.partial", (1, 1))
    cache.prune(kept, 500)
    assert not (kept / ".left.partial").exists()


def test_some_entries_have_the_folder_looked_through(kept, monkeypatch):
    monkeypatch.setattr(cache, "MOST", 500)
    names = [f"check-{number:040x}" for number in range(300)]
    for name in names:
        cache.write(name, b"x" * 100)
    left = sorted(path.name for path in kept.iterdir())
    assert left[-43:] == names[-43:] and 43 < len(left) < 48, (
        "the 257th has the older ones looked through, down to 375 bytes"
    )


def test_show_and_clear(kept, stool, tmp_path, capsys):
    found(stool)
    machine = tmp_path / "own" / "artipg_dsl" / "compiled" / "machine-0-0.so"
    machine.parent.mkdir(parents=True)
    machine.write_bytes(b"code")
    files = len(list(kept.iterdir())) + 1
    assert main(["cache"]) == 0
    said = capsys.readouterr().out
    assert "findings: 1 file" in said and "the compiled backend: 1 file" in said
    assert main(["cache", "clear"]) == 0
    assert f"removed {files} files" in capsys.readouterr().out and not list(kept.iterdir()) and not machine.exists()
    os.environ["APGC_CACHE"] = "off"
    assert main(["cache"]) == 0 and "nothing is kept" in capsys.readouterr().out


@pytest.mark.slow
def test_processes_share_a_folder_and_give_the_same_bytes(kept, stool):
    """Cold, all at once; then kept; then off: the files of all are equal."""
    root = Path(cache.__file__).parents[1]

    def start(out, **more):
        command = [sys.executable, "-m", "artipg_dsl", "sample", str(stool), "-n", "3", "-o", str(stool.parent / out)]
        env = {**os.environ, "PYTHONPATH": str(root), **more}
        return subprocess.Popen(command, env=env, stderr=subprocess.DEVNULL)

    for process in [start("a"), start("b")]:
        assert process.wait() == 0
    assert start("c").wait() == 0 and start("d", APGC_CACHE="off").wait() == 0
    first = {path.name: path.read_bytes() for path in (stool.parent / "a").iterdir() if path.name != "manifest.json"}
    for out in "bcd":
        for name, data in first.items():
            assert (stool.parent / out / name).read_bytes() == data, (out, name)


def hulls(program):
    """The faces of the pieces of two objects, with nothing found in this process; whether one had to be found."""
    for held in (facts._facts, pieces._known, pieces._mesh_hulls, pieces._hull_steps):
        held.cache_clear()
    batch = Sampler(program).batch(range(2), 0, checked=False)
    found = [
        (g.name, g.vertices.tobytes(), g.faces.tobytes())
        for site in batch.sites()
        for c in site.clouds
        for g in c.groups()
    ]
    new = bool(facts._changed)
    facts.flush()
    return found, new


def test_hulls_are_kept_and_verified(kept, monkeypatch):
    program = Session.of("Faucet").sampler.program
    first = hulls(program)
    assert first[1] and hulls(program) == (first[0], False)
    for change in (
        lambda held: [[used, faces[3:]] for used, faces in held] if held else None,  # open
        lambda held: [[[10**6, *used[1:]], faces] for used, faces in held] if held else None,
        lambda held: "hulls",
        lambda held: [[used, [10**20, *faces[1:]]] for used, faces in held] if held else None,
    ):
        for path in kept.glob("facts-*"):
            entry = json.loads(cache.read(path.name))
            spoilt = {name: change(held) if name.startswith("hulls") else held for name, held in entry.items()}
            spoilt |= {name: 13 for name in entry if name.startswith("hull steps")}
            cache.write(path.name, json.dumps(spoilt).encode())
        assert hulls(program)[0] == first[0]
    monkeypatch.setenv("APGC_CACHE", "off")
    assert hulls(program) == (first[0], False)


def test_solids_are_examined_once(kept, stool, monkeypatch):
    """A file is edited, its solids are not."""
    first = found(stool)
    stool.write_text(PROGRAM + "# edited\n")
    facts._facts.cache_clear()
    monkeypatch.setattr(solids, "seams", lambda *_: pytest.fail("examined again"))
    assert found(stool) == (first[0], True)


@pytest.mark.parametrize("data", [{"closed": 1, "missed": [True, "x"]}, {"closed": None, "missed": ["x"]}, {}, []])
def test_a_false_fact_about_a_solid_counts_for_nothing(kept, stool, data):
    first = found(stool)
    for path in kept.glob("check-*"):
        path.unlink()
    for path in kept.glob("facts-*"):
        cache.write(path.name, json.dumps(data).encode())
    facts._facts.cache_clear()
    assert found(stool) == (first[0], True)


def test_places_of_quadratures_are_found_once(kept, monkeypatch):
    primitives = Session.of("Mouse").sampler.program.primitives.values()

    def times():
        facts._facts.cache_clear()
        quadrature._rules.cache_clear()
        return [[len(weight) for _, _, weight in quadrature._rules(primitive)] for primitive in primitives]

    first = times()
    facts.flush()
    monkeypatch.setattr(quadrature, "_find_times", lambda _: pytest.fail("found again"))
    assert times() == first


def known(program, monkeypatch):
    """What is known of the surfaces, with nothing found in this process, and how much of it was found anew."""
    found = []
    for module, name in (
        (topology, "_found"),
        (topology, "_angles"),
        (topology, "_outwards"),
        (density, "_found"),
        (flat, "_shape"),
    ):
        do = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *given, do=do: found.append(1) or do(*given))
    for held in (
        facts._facts,
        topology.topology,
        topology.turns,
        topology.orientation,
        density.kind,
        flat.shapes,
        flat.convex,
    ):
        held.cache_clear()
    said = []
    for primitive in program.primitives.values():
        count = len(surfaces(primitive))
        variant = next(iter(variants(primitive)))
        shape = topology.topology(primitive, variant)
        said.append(
            [
                repr(value.tolist() if isinstance(value, np.ndarray) else value)
                for value in map(
                    shape.__getattribute__,
                    ("patches", "orientation", "matches", "collapsed", "step_class", "turn", "closed"),
                )
            ]
        )
        said.append([topology.turns(primitive, patch) for patch in range(count)])
        said.append([topology.orientation(primitive).tolist(), flat.shapes(primitive).tolist(), flat.convex(primitive)])
        for kind in (density.kind(primitive, patch) for patch in range(count)):
            profile = None if kind.profile is None else kind.profile.tobytes()
            said.append((kind.nodes, profile, kind.factor, kind.reference, kind.order))
    facts.flush()
    monkeypatch.undo()
    return said, len(found)


@pytest.mark.slow
def test_what_surfaces_are_like_is_kept_and_verified(kept, monkeypatch):
    place = str(kept)

    def again():
        monkeypatch.setenv("APGC_CACHE", place)
        return known(program, monkeypatch)

    program = Session.of("Kettle").sampler.program
    first = again()
    assert first[1] > 100 and again() == (first[0], 0)
    monkeypatch.setenv("APGC_CACHE", place)
    for change in (
        lambda held: None,
        lambda held: "x",
        lambda held: held[:-1] if isinstance(held, list) else {},
        lambda held: held | {"matches": held["matches"][1:], "nodes": [0, 0]} if "matches" in held else [7] * 50,
    ):
        for path in kept.glob("facts-*"):
            entry = json.loads(cache.read(path.name))
            names = ("topology", "turns", "orientation", "kind", "flat", "convex")
            spoilt = {
                name: change(held) if name.startswith(names) and not isinstance(held, bool) else held
                for name, held in entry.items()
            }
            cache.write(path.name, json.dumps(spoilt).encode())
        assert again()[0] == first[0]
        monkeypatch.setenv("APGC_CACHE", place)


def loaded_by(arguments: list[str], held: set[str]) -> str:
    """Which of some modules a process of ``apgc`` has loaded at its end."""
    code = "import sys; from artipg_dsl.cli.main import main; main(sys.argv[1:]);"
    code += f" print(sorted({held} & set(sys.modules)))"
    env = {**os.environ, "PYTHONPATH": str(Path(cache.__file__).parents[1])}
    done = subprocess.run([sys.executable, "-c", code, *arguments], env=env, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


def test_a_kept_program_is_sampled_without_what_it_does_not_need(kept, stool):
    held = {
        "lark",
        "multiprocessing",
        "numpy.random",
        "trimesh",
        "jinja2",
        "artipg_dsl.semantics",
        "numpy.ma",
        "numpy.char",
    }
    for out in ("first", "second"):
        found = loaded_by(["sample", str(stool), "-n", "1", "-o", str(stool.parent / out)], held)
    assert found == "[]"


def test_a_category_is_checked_without_what_that_does_not_need(kept, tmp_path):
    """A microwave, whose buttons are looked at, with one number changed once its library is kept."""
    edited, text = tmp_path / "microwave.apg", (categories_dir() / "microwave.apg").read_text()
    for width in ("41cm", "42cm"):
        edited.write_text(text.replace("in 40cm ..", f"in {width} .."))
        found = loaded_by(["check", str(edited)], {"lark", "multiprocessing", "numpy.ma", "numpy.char", "scipy"})
    assert found == "[]"

"""Wrong words on the command line: one line that says what is wrong, one that says what to try, exit code 2."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.loaders import Stored
from artipg_dsl.run.manifest import make_relative
from artipg_dsl.session import Session, categories

from .helpers import CHEST, Apgc, command, environment


@pytest.mark.parametrize(
    ("words", "told", "hint"),
    [
        ("sampel Microwave", "there is no command `sampel`", "did you mean `sample`?"),
        ("sample Microwave --formt glb", "apgc sample has no option --formt", "did you mean --format?"),
        ("sample Microwave --detail-strenght 1", "no option --detail-strenght", "did you mean --detail-strength?"),
        ("sample Microwave --no-mesh", "apgc sample has no option --no-mesh", "did you mean --no-meshes?"),
        ("sample Microwave --strength=0.5", "apgc sample has no option --strength", "did you mean --detail-strength?"),
        ("sample Microwave more", "unexpected argument more", "apgc sample --help"),
        ("sample Microwave -n 0", "0 is not a number from 1", "apgc sample --help"),
        ("sample Microwave -n 4 --number=5", "--number is given twice, with different values", "keep one"),
        ("sample", "required: DIR|NAME|FILE", "apgc sample --help"),
        ("compile Microwave --emit tree", "there is no --emit `tree`", "graph, ast, typed"),
        (f"sample {CHEST} --variant 3", "--variant applies to mutants", "--mutate"),
        (f"sample {CHEST} --states open=45", "`open=45` has no unit", "deg"),
        (f"sample {CHEST} --gripper stroke=10", "`stroke=10` has no unit", "stroke=10mm"),
        (f"sample {CHEST} --gripper stroke=10cm,stroke=9cm", "stroke is given twice", ""),
        (f"sample {CHEST} --set width=45..60cm", "`width` cannot be a range, 45..60cm", "--prior"),
        (f"sample {CHEST} --set width=9m", "it lies in 30cm .. 60cm", "apgc new NAME --from CATEGORY"),
        (f"sample {CHEST} --set width=4furlong", "`furlong` in width=4furlong is not a unit", "mm, cm, m"),
        (f"sample {CHEST} -o -", "- means standard output, but a folder is needed", ""),
        (f"export {CHEST} --format obj -o -", "- means standard output, but a folder is needed", ""),
        ("mutate out -o -", "- means standard output, but a folder is needed", ""),
        (f"render {CHEST} -o -", "- means standard output, but a picture needs a file", ""),
        (f"render {CHEST} -n 1 --view 200", "unknown view '200'", "an elevation lies between"),
        (f"render {CHEST} -n 1 --tile 8", "a tile is 8 pixels wide", "from 16 to 4096"),
        ("report Door --html - --json", "--html - writes the page to standard output", "name"),
        (f"sample {CHEST} --mutate cpa --variant {10**30}", "the variant is 1000000", ""),
        (f"sample {CHEST} --mutate apa,apa", "the operation apa is given twice", "each is applied once"),
        ("sample Microwave --mutate=", "--mutate is empty", "a variable of the shell"),
        (f"compile {CHEST} --emit ast -o chest.apgc", "which --emit ast is not", "another ending"),
        (f"compile {CHEST} --force", "--force replaces a file, and none is written", "-o FILE"),
        (f"report {CHEST} --force", "--force replaces the page, and none is written", "--html FILE"),
        ("new 3D", "`3D` cannot name", "a name such as DeskLamp"),
        ("new Cuboid", "uses the library's `Cuboid`", "another name"),
        ("new Foo -o .", ". is a folder", "write foo.apg"),
    ],
)
def test_wrong_words(apgc: Apgc, words: str, told: str, hint: str) -> None:
    code, out, err = apgc(*words.split())
    assert (code, out) == (2, "")
    first, *more = err.splitlines()
    assert first.startswith("error: ") and told in first
    assert len(more) <= 1 and hint in "".join(more)


@pytest.mark.parametrize(("words", "told"), [(("-o", ""), "-o"), (("--set", " "), "--set"), (("",), "an argument")])
def test_what_is_empty_is_refused(apgc: Apgc, words: tuple[str, ...], told: str) -> None:
    code, _, err = apgc("sample", CHEST, *words)
    assert code == 2 and f"error: {told} is empty" in err


def test_a_joint_that_is_misspelt(apgc: Apgc, tmp_path: Path) -> None:
    code, _, err = apgc("sample", CHEST, "-n", 1, "--points", 8, "-o", tmp_path, "--states", "opn=4deg")
    assert code == 2 and "did you mean `open`?" in err


def test_compile_leaves_the_program_alone(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "chest.apg"
    program.write_bytes(Path(CHEST).read_bytes())
    code, _, err = apgc("compile", program, "-o", program)
    assert code == 2 and "chest.apgc" in err
    assert program.read_bytes() == Path(CHEST).read_bytes()


def test_numbers_without_end_and_signs_of_word_processors(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "signs.apg"
    program.write_text(f"apg 1\nlet a = 1e999\nlet b = 3 − 2\nlet c = 1{'0' * 400}/3\n", encoding="utf-8")
    code, out, _ = apgc("check", program)
    assert code == 1 and out.count("this number is too large") == 2 and "the keyboard's minus sign" in out


def test_links_devices_and_rights_stay_what_they_are(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "real.apg"
    program.write_text("apg 1\ncategory A {\n\tlet a = 1\n}\n")
    program.chmod(0o640)
    (tmp_path / "link.apg").symlink_to("real.apg")
    assert apgc("fmt", tmp_path / "link.apg")[0] == 0
    assert (tmp_path / "link.apg").is_symlink() and "\n  let a = 1\n" in program.read_text()
    assert program.stat().st_mode & 0o777 == 0o640
    assert apgc("compile", CHEST, "-o", os.devnull)[0] == 0
    assert not Path(os.devnull).is_file()


@pytest.mark.skipif(
    os.name == "nt", reason="a shell of Windows closes no streams, and keeps the folder that it works in"
)
def test_started_without_streams_and_without_a_folder(tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    line = 'cd gone && rmdir ../gone && "$@" >&- 2>&- <&-; echo $?; "$@" 2>&1'
    found = subprocess.run(
        ["sh", "-c", line, "sh", *command("check", "x.apg")],
        cwd=tmp_path, env=environment(), text=True, capture_output=True, timeout=60,
    )  # fmt: skip
    assert found.stdout.splitlines() == [
        "1", "error: the working folder is no longer there", "  = help: change to one that is: cd"
    ]  # fmt: skip


@pytest.mark.parametrize("name", ["program.apg", "program\udcff.apg"])  # also one that is no text
def test_output_is_utf_8_whatever_the_locale_says(tmp_path: Path, name: str) -> None:
    try:
        (tmp_path / name).write_text("apg 1\ncategory Größe { part }\n", "utf-8")
    except OSError as error:
        pytest.skip(f"the file system takes no such name: {error.strerror}")
    found = subprocess.run(
        command("check", tmp_path / name), env=environment(PYTHONIOENCODING="ascii"), capture_output=True, timeout=60
    )
    assert found.returncode == 1
    assert "category Größe { part }" in found.stdout.decode("utf-8")
    assert name.encode("ascii", "backslashreplace") in found.stdout


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no device that is full")
def test_output_that_cannot_be_written(tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        found = subprocess.run(
            command("explain"), stdout=full, stderr=subprocess.PIPE, text=True, env=environment(), timeout=60
        )
    assert found.returncode == 1
    assert found.stderr == "error: cannot write the output: No space left on device\n"


def test_a_word_of_ones_own(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "bin.apg"
    text = (
        "apg 1\nuse primitives { Cuboid }\nuse vocabularies { semantic }\ncategory Bin {\n"
        "  root part body : Cuboid(size = [20cm, 20cm, 40cm])\n  label semantic.tread on body\n}\n"
    )
    program.write_text(text)
    code, out, _ = apgc("check", program)
    assert code == 1 and "`vocabulary semantic { tread }`, and remove `semantic` from `use`" in out
    program.write_text(
        text.replace("vocabularies { semantic }", "vocabularies { affordance }\nvocabulary semantic { tread }")
    )
    assert apgc("sample", program, "-n", 1, "--points", 8, "-o", tmp_path / "out")[0] == 0
    words = json.loads((tmp_path / "out" / "manifest.json").read_text())["vocabularies"]["semantic"]
    assert words[:2] == ["unlabelled", "body"] and words[-1] == "tread"  # class 0 is unlabelled


def test_an_alternative_that_leaves_a_size_open(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "box.apg"
    program.write_text(
        "apg 1\nuse primitives { Cuboid, Cylinder }\ncategory Box {\n  root part a : Cuboid(size = [9cm, 9cm, 9cm])\n"
        "  part b : Cuboid(size = [3cm, _, 3cm]) | Cylinder(radius = 1cm, height = 2cm)\n  connect b.bottom on a.top\n}\n"
    )
    code, out, _ = apgc("check", program)
    assert code == 1 and "`Cuboid` is one of several alternatives" in out and "let the role pass it in" in out


def test_one_file_of_text_goes_to_standard_output(apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code, compiled, err = apgc("compile", CHEST, "-o", "-")
    assert (code, compiled.split("\n", 1)[0]) == (0, "apgc 1") and "wrote" not in err
    assert apgc("compile", CHEST) == (0, compiled, err)
    code, program, _ = apgc("new", "DeskLamp", "-o", "-")
    assert code == 0 and program.startswith("apg 1\n") and "category DeskLamp" in program
    code, page, _ = apgc("report", CHEST, "-n", 2, "--html", "-")
    assert code == 0 and page.startswith("<!doctype html>")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("numpy.nowhere", ("the installed numpy has no numpy.nowhere", "pip install -U artipg_dsl")),
        ("nowhere.at_all", ("the package nowhere is not installed", "pip install artipg_dsl")),
    ],
)
def test_a_package_that_lacks_something(
    apgc: Apgc, monkeypatch: pytest.MonkeyPatch, name: str, told: tuple[str, str]
) -> None:
    def run(_: object) -> int:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr("artipg_dsl.cli.categories.run", run)
    code, _, err = apgc("categories")
    assert code == 1 and all(words in err for words in told)


@pytest.mark.parametrize("end", ["\r\n", "\r"])
def test_ends_of_lines_of_other_systems(apgc: Apgc, tmp_path: Path, end: str) -> None:
    text = Path(CHEST).read_text().replace("root part trunk", "root prt trunk")
    (tmp_path / "chest.apg").write_bytes(text.replace("\n", end).encode())
    code, out, _ = apgc("check", tmp_path / "chest.apg")
    assert code == 1 and "chest.apg:18:8\n" in out


def test_a_program_that_is_not_there(apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stool.apg").write_text("apg 1\n")
    (tmp_path / "bad.apgc").write_bytes(b"\x87\xff")
    os.mkfifo(tmp_path / "pipe.apg")
    for name, told in (
        ("stool", "did you mean `stool.apg`?"),
        ("stool.txt", "there is no file stool.txt\n  = help: a program is an .apg file"),
        ("pipe.apg", "pipe.apg is a pipe or a device, not a file\n  = help: a program is read more than once"),
        ("-", "there is no category `-`\n  = help: only `apgc fmt -` reads a program from standard input"),
        (300 * "a", "aaa cannot be read: File name too long"),
        ("parts/stool", "there is no file parts/stool\n  = help: check the path, and end it with .apg"),
    ):
        assert told in apgc("check", name)[1]
    assert "bad.apgc: this is not a compiled program\n" in apgc("sample", "bad.apgc")[2]
    for name, told in (
        ("samples", "error: there is neither a folder nor a category `samples`\n"),
        ("Chare", "there is no category `Chare`\n  = help: did you mean `Chair`?"),
        ("stool", "did you mean `stool.apg`?"),
    ):
        assert told in apgc("render", name)[2]
    with pytest.raises(UserError, match="there is no folder samples"):
        Stored(["samples"], "segmentation")


def test_a_folder_that_is_called_like_a_category(apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "Chair").mkdir()
    (tmp_path / "Stool").mkdir()
    assert Session.of("Chair").path == categories()["Chair"]
    assert make_relative("Chair", tmp_path / "out") == "Chair"  # what a manifest calls it
    code, out, _ = apgc("check", "Stool")
    assert code == 1 and "Stool is a folder" in out


def test_what_is_left_at_the_end_is_not_looked_through() -> None:
    code = """
        import atexit, gc
        atexit.register(lambda: print(gc.get_freeze_count() > 10_000))  # the first to be registered is the last to be called
        from artipg_dsl.cli.main import main
        main(["explain", "too-deep"])
        print(gc.get_freeze_count())
    """
    done = subprocess.run([sys.executable, "-c", dedent(code)], env=environment(), capture_output=True, text=True)
    assert done.stdout.splitlines()[-2:] == ["0", "True"], done.stderr

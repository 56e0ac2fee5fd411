"""Names and texts from programs arrive in files as data: nothing ends a string, a tag or a path, and no two things share a name."""

from __future__ import annotations

import json
import re
import struct
import xml.etree.ElementTree as ElementTree
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import mujoco
import pytest
from pxr import Usd

from artipg_dsl.api import Samples, load
from artipg_dsl.cli.main import main
from artipg_dsl.errors import UserError
from artipg_dsl.graph.reading import TextError, from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.runtime.tags import make_distinct
from artipg_dsl.session import Session

TEXTS = [
    '"><script>alert(1)</script>',
    "a & b ]]> <!-- --> ' \\ é \u2028 \x1b[31m",
    "../../etc/passwd",
    "{{ 7 * 7 }}{% raw %}",
    "x" * 5000,
]
PROGRAM = """apg 1
use primitives {{ Cuboid }}
use vocabularies {{ semantic }}
material clear       {{ density 1000kg/m3  colour [0.5, 0.5, 0.5] }}
material glass_clear {{ density 1000kg/m3  colour [0.9, 0.5, 0.5] }}
material CLEAR       {{ density 1000kg/m3  colour [0.1, 0.5, 0.5] }}
## {text}
category Clash {{
  param width : length in 40cm .. 60cm = 50cm  ## {text}
  root part base : Cuboid(size = [10cm, width, 5cm])
  part door       : Cuboid(size = [2cm, 2cm, 2cm])
  part Door       : Cuboid(size = [2cm, 2cm, 2cm])
  part door_glass : Cuboid(size = [2cm, 2cm, 2cm])
  part con        : Cuboid(size = [2cm, 2cm, 2cm])
  joint a : prismatic base.top -> door.bottom       at y = base.left - 5cm   range 0cm .. 5cm
  joint b : prismatic base.top -> Door.bottom       at y = base.left - 15cm  range 0cm .. 5cm
  joint c : prismatic base.top -> door_glass.bottom at y = base.left - 25cm  range 0cm .. 5cm
  joint d : prismatic base.top -> con.bottom        at y = base.left - 35cm  range 0cm .. 5cm
  material glass_clear on door
  material clear on Door, door_glass
  material CLEAR on con
  label semantic.body on base
  allow floating con because "{quoted}"
  require width <= 55cm else "{quoted}"
}}
"""
FORMATS = "points,urdf,mjcf,sdf,usd,glb,obj,partnet-mobility"


def program(text: str) -> str:
    quoted = text.replace("\\", "\\\\").replace('"', '\\"')
    return PROGRAM.format(text=text.replace("\u2028", " "), quoted=quoted)


@pytest.fixture(scope="module", params=TEXTS, ids=range(len(TEXTS)))
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "clash.apg").write_text(program(request.param), encoding="utf-8")
    out = folder / "out"
    formats = FORMATS if request.param is TEXTS[0] else "points,urdf,glb"
    assert (
        main(["sample", str(folder / "clash.apg"), "-n", "1", "--points", "16", "--format", formats, "-o", str(out)])
        == 0
    )
    return request.param, out


def test_texts_stay_in_their_strings(written: tuple[str, Path]) -> None:
    text, out = written
    manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["about"] == " ".join(text.replace("\u2028", " ").split()) or text[:20] in manifest["about"]
    for path in out.rglob("*"):
        assert path.resolve().is_relative_to(out.resolve())
        if path.suffix in (".urdf", ".xml", ".sdf", ".config", ".srdf"):
            tags = {element.tag for element in ElementTree.fromstring(path.read_bytes()).iter()}
            assert "script" not in tags
        elif path.suffix == ".glb":
            data = path.read_bytes()
            json.loads(data[20 : 20 + struct.unpack("<I", data[12:16])[0]])
        elif path.suffix == ".usda":
            assert Usd.Stage.Open(str(path))
    for line in (out / "annotation-00000.jsonl").read_text(encoding="utf-8").split("\n")[:-1]:
        json.loads(line)


def test_no_two_files_and_no_two_things_share_a_name(written: tuple[str, Path]) -> None:
    text, out = written
    folder = out / "objects" / "000000"
    names = [path.relative_to(folder).as_posix().casefold() for path in folder.rglob("*") if path.is_file()]
    assert len(set(names)) == len(names)
    assert not any(Path(name).name.partition(".")[0] == "con" for name in names)
    root = ElementTree.fromstring((folder / "object.urdf").read_bytes())
    seen = {mesh.get("filename") for mesh in root.findall(".//visual//mesh")}
    assert len(seen) == len(root.findall("link")) == 5
    looks = {
        link.get("name"): [m.get("name") for m in link.findall("visual/material")] for link in root.findall("link")
    }
    assert looks["door"] == ["glass_clear"] and looks["door_glass"] == ["clear"]
    if text is TEXTS[0]:
        model = mujoco.MjModel.from_xml_path(str(folder / "object.xml"))
        assert model.njnt == 4 and len(list((folder / "obj").glob("*.obj"))) == 5


class Tags(HTMLParser):
    def __init__(self, text: str):
        super().__init__()
        self.found: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.found.add(tag)


@pytest.mark.parametrize("text", TEXTS[:2], ids=range(2))
def test_pages_and_notebooks_escape_texts(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "clash.apg").write_text(program(text), encoding="utf-8")
    page = tmp_path / "report.html"
    main(["report", str(tmp_path / "clash.apg"), "-n", "4", "--html", str(page), "--unchecked"])
    assert "script" not in Tags(page.read_text(encoding="utf-8")).found
    assert "\x1b[31m" not in "".join(capsys.readouterr())
    made: Samples = load(program(text))
    assert Tags(made._repr_html_()).found == {"img", "p"}


def test_messages_hold_no_control_characters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "clash.apg").write_text(program(TEXTS[1]).replace("<= 55cm", "<= 5cm"), encoding="utf-8")
    assert main(["sample", str(tmp_path / "clash.apg"), "-n", "1", "-o", str(tmp_path / "o")]) == 1
    assert "\x1b[31m" not in "".join(capsys.readouterr())


def test_a_name_too_long_for_a_file_is_told(tmp_path: Path) -> None:
    made = load(program("plain").replace("door_glass", "d" * 300))
    with pytest.raises(UserError, match="too long"):
        made.to_obj(tmp_path)


FREE = [
    "a'b\"c\\d`e",
    "a\nb\r\nc\td",
    "a\x00b",
    "\u202eevil\u2066",
    "\x01\x1b[31m\x7f\x85",
    "]]> & <b></script>",
    "",
    "%n%s $HOME `id`",
]
NAMES = {
    "category": "Clash",
    "parameter": "width",
    "part": "door_glass",
    "joint": "a",
    "material": "glass_clear",
    "word": "body",
    "vocabulary": "semantic",
    "template": "Cuboid",
    "surface": "front",
}


@cache
def artefact() -> str:
    session = Session.of_text(program("about it"), "/home/clash.apg")
    assert session.lowering is not None
    return to_text(session.lowering.program)


def edited(old: str, new: str) -> str:
    """The compiled program with another text (or number) wherever it stands."""
    assert old in artefact()
    return artefact().replace(old, new)


def sealed(text: str) -> str:
    return f"{text}\n# hash {from_text(text).hash}\n"


@pytest.mark.parametrize("place", ["about it", "/home/clash.apg"], ids=["text", "file"])
def test_free_texts_of_edited_artefacts_stay_in_their_strings(
    place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Documentation, messages, reasons and names of files, in every format and on a page."""
    for number, text in enumerate(FREE if place == "about it" else ["../../evil\x00\n</script>"]):
        folder, asked = tmp_path / str(number), ["-n", "1", "--points", "16"]
        folder.mkdir()
        (folder / "a.apgc").write_text(
            sealed(edited(json.dumps(place), json.dumps(text))), encoding="utf-8", newline="\n"
        )
        formats = FORMATS if number == 0 else "points,annotation,urdf,glb"
        asked += ["--format", formats, "-o", str(folder / "out")]
        assert main(["sample", str(folder / "a.apgc"), *asked]) == 0, capsys.readouterr().err
        assert {path.name for path in folder.iterdir()} == {"a.apgc", "out"}
        for path in (folder / "out").rglob("*"):
            if path.suffix in (".urdf", ".xml", ".sdf", ".config", ".srdf"):
                assert "script" not in {element.tag for element in ElementTree.fromstring(path.read_bytes()).iter()}
            elif path.suffix == ".json":
                json.loads(path.read_text("utf-8"))
            elif path.suffix == ".jsonl":
                for line in path.read_text("utf-8").split("\n")[:-1]:
                    json.loads(line)
            elif path.suffix == ".usda":
                assert Usd.Stage.Open(str(path))
            elif path.suffix == ".glb":
                data = path.read_bytes()
                json.loads(data[20 : 20 + struct.unpack("<I", data[12:16])[0]])
        assert not {c for c in "".join(capsys.readouterr()) if ord(c) < 32} - {"\n", "\t", "\r"}
    assert main(["report", str(folder / "a.apgc"), "-n", "2", "--html", str(folder / "r.html"), "--unchecked"]) == 0
    assert "script" not in Tags((folder / "r.html").read_text("utf-8")).found


@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
def test_names_of_edited_artefacts_are_words_or_are_refused(name: str) -> None:
    for evil in (*FREE, "../../tmp/evil", "/tmp/evil", "..", "</script>", "\ud800"):
        with pytest.raises(TextError, match="line|incomplete"):
            from_text(edited(json.dumps(name), json.dumps(evil)))


@pytest.mark.parametrize("number", ["1e308", "-1e308", "1e999", "nan"])
@pytest.mark.parametrize("place", ["const 0.025\n", "const 0.4\n", "[1000.0 ", "[0.9 "])
def test_numbers_beyond_all_bounds_are_refused(
    place: str, number: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = edited(place, re.sub(r"\d+\.\d+", number, place))
    try:
        (tmp_path / "a.apgc").write_text(sealed(text), encoding="utf-8")
    except TextError as error:
        assert "a finite number is expected" in str(error)
        return
    asked = ["sample", str(tmp_path / "a.apgc"), "-n", "1", "--format", "urdf", "-o", str(tmp_path / "out")]
    assert main(asked) == 1
    told = capsys.readouterr().err
    assert "not finite or far too large" in told or "no valid Clash" in told


def test_tags_that_meet_stay_apart() -> None:
    import numpy as np

    names = ["row[1].turn", "row_1.turn", "row[1].turn", "row_1.turn", "row_1.turn_2"]
    assert make_distinct(names, np.array([0, 0, 1, 2, 2])) == [
        "row_1.turn",
        "row_1.turn_2",
        "row_1.turn",
        "row_1.turn",
        "row_1.turn_2",
    ]
    assert make_distinct(["a[1]", "a_1", "a_1_2"], np.zeros(3, dtype=int)) == ["a_1", "a_1_3", "a_1_2"]


CLASHES = """apg 1
use primitives { Cuboid }
template Cube {
  part block : Cuboid(size = [3cm, 3cm, 3cm])
}
category Clashes {
  root part world : Cuboid(size = [40cm, 40cm, 5cm])
  part a : Cube
  align a.block.center = [10cm, 10cm, 42mm]
  joint drive : screw world -> a about line(at = a.block.center, along = z) range 0turn .. 1turn pitch 1cm
  part a_carrier : Cube
  align a_carrier.block.center = [10cm, 0, 42mm]
  joint drive_advance : prismatic world -> a_carrier along z range 0cm .. 1cm
  part b : Cube
  align b.block.center = [-10cm, 10cm, 42mm]
  joint look : ball world -> b at b.top range 0deg .. 5deg
  part b_carrier_1 : Cube
  align b_carrier_1.block.center = [-10cm, 0, 42mm]
  joint look_swing : prismatic world -> b_carrier_1 along z range 0cm .. 1cm
  part __c__ : Cube
  align __c__.block.center = [0, 0, 42mm]
  joint world_1_free : prismatic world -> __c__ along z range 0cm .. 1cm
}
"""


def test_what_formats_add_has_names_of_its_own(tmp_path: Path) -> None:
    """Slides of screws, hinges of balls and a free base beside joints and links that are called the same; and the root is not
    called as the ground of all simulators is."""
    (tmp_path / "clashes.apg").write_text(CLASHES)
    out = tmp_path / "out"
    assert main(["sample", str(tmp_path / "clashes.apg"), "-n", "1", "--format", "urdf,mjcf,sdf", "-o", str(out)]) == 0
    folder = out / "objects" / "000000"
    for file in ("object.urdf", "model.sdf"):
        root = ElementTree.fromstring((folder / file).read_bytes())
        for tag in ("link", "joint"):
            names = [element.get("name") for element in root.findall(f".//{tag}") if element.get("name")]
            assert len(set(names)) == len(names) >= 5
            assert not any(re.fullmatch("world|__.*__", name) for name in names)
    for file, free in (("object", 0), ("object_free", 1)):
        model = mujoco.MjModel.from_xml_path(str(folder / f"{file}.xml"))
        assert (model.nbody, model.njnt) == (7, 6 + free)

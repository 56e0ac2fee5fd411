"""apgc new: a category to start from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.cli.new import snake, starting_point
from artipg_dsl.session import Session, categories

from .helpers import Apgc


def test_starting_point_is_sound() -> None:
    session = Session.of_text(starting_point("DeskLamp"), "desk_lamp.apg")
    batch = session.sampler.batch(np.arange(100), 0, checked=True)
    session.advise()
    assert not session.report.diagnostics
    assert batch.program.name == "DeskLamp"


@pytest.mark.parametrize(
    "name, file", [("DeskLamp", "desk_lamp"), ("USB", "usb"), ("USBStick", "usb_stick"), ("Lamp2", "lamp2")]
)
def test_file_names(name: str, file: str) -> None:
    assert snake(name) == file


def test_writes_once(apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert apgc("new", "DeskLamp")[0] == 0
    assert apgc("check", "desk_lamp.apg")[1] == ""
    Path("desk_lamp.apg").write_text("mine", encoding="utf-8")
    code, _, err = apgc("new", "DeskLamp")
    assert code == 1 and "desk_lamp.apg exists" in err and "--force" in err
    assert Path("desk_lamp.apg").read_text(encoding="utf-8") == "mine"
    assert apgc("new", "DeskLamp", "--force")[0] == 0
    assert apgc("new", "DeskLamp", "-o", "there/lamp.apg")[0] == 0
    assert Path("there/lamp.apg").read_text(encoding="utf-8") == starting_point("DeskLamp")


def test_copies_a_category_to_change(apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert apgc("new", "BigMug", "--from", "mug")[0] == 0
    text, shipped = Path("big_mug.apg").read_text(encoding="utf-8"), categories()["Mug"].read_text(encoding="utf-8")
    assert text == shipped.replace("category Mug {", "category BigMug {") != shipped
    assert Session.of("big_mug.apg").sampler.batch(np.arange(3), 0).program.name == "BigMug"
    assert apgc("new", "Huge", "--from", "big_mug.apg", "-o", "-")[1] == text.replace("BigMug", "Huge")
    code, _, err = apgc("new", "Thing", "--from", "Mugg")
    assert code == 1 and "there is no category `Mugg`" in err and "did you mean `Mug`?" in err
    Path("module.apg").write_text("apg 1\n", encoding="utf-8")
    code, _, err = apgc("new", "Thing", "--from", "module.apg")
    assert code == 2 and "module.apg declares no category" in err
    Path("broken.apg").write_text("apg 1\ncategory {", encoding="utf-8")
    assert apgc("new", "Thing", "--from", "broken.apg")[0] == 1 and not Path("thing.apg").exists()


@pytest.mark.parametrize(
    "arguments, said",
    [
        (("desk_lamp",), "write DeskLamp"),
        (("desk-lamp.apg",), "write DeskLamp"),
        (("3",), "write a name such as DeskLamp"),
        (("param",), "it is a word of the language"),
        (("Lamp", "-o", "lamp.txt"), "write lamp.apg"),
    ],
)
def test_bad_names(
    apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, err = apgc("new", *arguments)
    assert code == 2 and said in err
    assert list(tmp_path.iterdir()) == []

"""`apgc watch` looks at a program whenever it is saved."""

import os
import signal
import subprocess
from pathlib import Path

import pytest

from .helpers import CHEST, command, environment

SHELF = """apg 1
use primitives { Cuboid }
template Shelf {
  param depth : length in 20cm .. 30cm = 25cm
  part board : Cuboid(size = [depth, 60cm, 2cm])
}
"""
STAND = """apg 1
use shelf { Shelf }
category Stand {
  root part shelf : Shelf()
  material oak on shelf
  label semantic.shelf on shelf
}
"""


@pytest.fixture
def watched(tmp_path):
    """A program beside its module, and a process that watches it; whatever it says is read line by line."""
    (tmp_path / "shelf.apg").write_text(SHELF)
    stand = tmp_path / "stand.apg"
    stand.write_text(STAND.replace("use shelf", "use materials { oak }\nuse vocabularies { semantic }\nuse shelf"))
    process = subprocess.Popen(
        command("watch", stand, "-o", tmp_path / "sheet.png", "-n", 1),
        env=environment(PYTHONUNBUFFERED="1"),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    with process:
        yield process, stand
        process.kill()


def until(process, *words):
    """What is said up to a line with one of the words."""
    found = []
    for line in process.stdout:
        found.append(line)
        if any(word in line for word in words):
            return "".join(found)
    pytest.fail("it ended: " + "".join(found))


def test_every_save_is_checked_and_drawn(watched):
    process, stand = watched
    sheet = stand.parent / "sheet.png"
    assert "no errors" in until(process, "drew 1 object")
    drawn = sheet.read_bytes()
    good = stand.read_text()

    stand.write_text(good.replace("semantic.shelf", "semantic.shelv"))
    assert "error[unknown-label]" in until(process, "1 error")
    assert sheet.read_bytes() == drawn  # the last one that was right

    beside = stand.parent / "new.apg"  # as editors save: written beside, then renamed
    beside.write_text(good.replace("Stand {", "Stand {  # another"))
    os.replace(beside, stand)
    assert "no errors" in until(process, "drew")
    assert sheet.read_bytes() == drawn

    (stand.parent / "shelf.apg").write_text(SHELF.replace("60cm", "160cm"))
    until(process, "drew")
    assert sheet.read_bytes() != drawn

    process.send_signal(signal.SIGINT)
    assert process.wait(20) == 0


def test_a_program_that_goes_away_is_waited_for(watched):
    process, stand = watched
    until(process, "drew")
    text = stand.read_text()
    stand.unlink()
    assert "error[missing-file]" in until(process, "1 error")
    stand.write_text(text)
    assert "no errors" in until(process, "drew")


def test_what_cannot_be_watched_is_refused(apgc, tmp_path):
    code, out, _ = apgc("watch", tmp_path / "none.apg")
    assert code == 1 and "error[missing-file]" in out
    picture = tmp_path / "mine.png"
    picture.write_text("mine")
    code, _, err = apgc("watch", CHEST, "-o", picture)
    assert code == 1 and "--force" in err and picture.read_text() == "mine"
    code, _, err = apgc("watch", CHEST, "--seed", 3)
    assert code == 2 and "add -o FILE" in err
    code, _, err = apgc("watch", CHEST, "-o", tmp_path / "sheet.jpg")
    assert code == 2 and "ends in .png" in err
    code, _, err = apgc("watch", Path(tmp_path / "a.apgc"))
    assert code == 2 and ".apg file" in err

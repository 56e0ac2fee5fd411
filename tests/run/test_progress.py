"""Long work tells that it goes on, and what it is at, also where nobody watches a terminal."""

import io
import time

from artipg_dsl.run import progress as module
from artipg_dsl.run.progress import Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_silent_for_short_work_where_nobody_watches():
    stream = io.StringIO()
    with Progress("Chest", stream) as progress:
        progress.stage("drawing")
        progress(1, 2)
    assert stream.getvalue() == ""


def test_a_line_now_and_then_with_the_stage(monkeypatch):
    monkeypatch.setattr(module, "SELDOM", 0.02)
    stream = io.StringIO()
    with Progress("validating", stream) as progress:
        progress.stage("checking them in all states")
        progress(1, 4)
        while stream.getvalue().count("\n") < 2:
            time.sleep(0.01)
    first = stream.getvalue().split("\n")[-2]
    assert first.startswith("validating: checking them in all states [") and "1/4" in first
    held = stream.getvalue()
    time.sleep(0.05)
    assert stream.getvalue() == held  # nothing after the work


def test_a_stage_that_is_counted_for_itself():
    stream = Terminal()
    with Progress("Chest", stream) as progress:
        progress.stage("pairs (step 4 of 7)", 0, 10)
        progress.drawn = 0.0
        progress.stage("pairs (step 4 of 7)", 5, 10)
        assert "5/10" in progress.line() and stream.getvalue().count("Chest: pairs (step 4 of 7) [") == 2
        progress.stage("sizes (step 5 of 7)", 0, 0)
        assert progress.line() == "Chest: sizes (step 5 of 7)"


def test_what_is_left_is_told_by_what_has_been_done_alone(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    progress = Progress("validating", io.StringIO())
    told = []
    for at, done in ((0, 20), (50, None), (60, 30), (65, None), (99, None), (190, None), (200, 40)):
        now[0] = float(at)
        if done is not None:
            progress(done, 50)  # 20 were there already
        told.append(progress.line().rsplit("  ")[-1])
    # nothing is done: no estimate; it runs down, and ends where the next has taken longer than all the rest should
    assert told[1:] == ["50 s", "120 s left", "115 s left", "81 s left", "190 s", "100 s left"]


def test_a_terminal_shows_the_stage_at_once_and_is_wiped():
    stream = Terminal()
    with Progress("Chest", stream) as progress:
        progress.stage("compiling")
        assert "Chest: compiling" in stream.getvalue()
    assert stream.getvalue().endswith("\r\x1b[K")

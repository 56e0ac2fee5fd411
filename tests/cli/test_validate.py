"""``apgc validate`` tells a watcher how far it is."""

from artipg_dsl.run import evidence
from artipg_dsl.run.evidence import examine
from artipg_dsl.run.job import open_job
from artipg_dsl.run.request import Request


def test_progress_is_told_before_every_step():
    told = []
    found = examine(
        open_job(Request("Globe", numbers=((0, 1),))), 2, progress=lambda done, steps: told.append((done, steps))
    )
    assert told == [(k, 4) for k in range(5)]
    assert found["objects"] == 2 and found["delivered"]["invalid"] == 0


def test_the_evidence_is_the_same_however_the_objects_are_divided(monkeypatch):
    job = open_job(Request("Laptop", numbers=((0, 5),)))
    whole = examine(job, 2)
    monkeypatch.setattr(evidence, "_TOGETHER", 2)
    assert examine(job, 2) == whole
    assert whole["drawn"]["objects"] == 6 and whole["attempts"] >= 6

"""``apgc validate`` tells a watcher how far it is."""

from artipg_dsl.run import evidence
from artipg_dsl.run.evidence import examine
from artipg_dsl.run.job import open_job
from artipg_dsl.run.request import Request


def test_every_step_and_the_objects_that_are_done_are_told():
    told = []
    found = examine(
        open_job(Request("Globe", numbers=((0, 1),))), 2, progress=lambda *count: told.append(count), stage=told.append
    )
    assert told[0] == (0, 2) and told[-1] == (2, 2)
    assert [words[-len("(step 1 of 4)") :] for words in told[1:-1]] == [f"(step {k} of 4)" for k in range(1, 5)]
    assert found["objects"] == 2 and found["delivered"]["invalid"] == 0


def test_the_evidence_is_the_same_however_the_objects_are_divided(monkeypatch):
    job = open_job(Request("Laptop", numbers=((0, 5),)))
    whole = examine(job, 2)
    monkeypatch.setattr(evidence, "_TOGETHER", 2)
    assert examine(job, 2) == whole
    assert whole["drawn"]["objects"] == 6 and whole["attempts"] >= 6

"""A run on a cluster: the same bytes as by one process, also where a worker is killed in the middle."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.cli.main import main
from artipg_dsl.errors import NoObject, UserError
from artipg_dsl.export.content import Content
from artipg_dsl.run.dataset import write_dataset
from artipg_dsl.run.job import Job, open_job
from artipg_dsl.run.output import Output
from artipg_dsl.run.request import read_request
from artipg_dsl.run.sharing import Workers

CHEST = Path(__file__).parents[1] / "cli" / "programs" / "chest.apg"
STUCK = """apg 1
use primitives { Cuboid }
category Box {
  root part body : Cuboid(size = [4cm, 4cm, 4cm])
  part lid : Cuboid(size = [1cm, 1cm, 1cm])
  align lid.bottom = body.top - 5mm
  joint slide : prismatic body -> lid along x range 0cm .. 1cm
}
"""


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def job() -> Job:
    return open_job(read_request(CHEST, n=48))


@pytest.mark.slow
def test_a_worker_is_killed_in_the_middle(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    output = Output(("points", "annotation", "urdf"), Content(Sampling(16)), 4)
    write_dataset(job(), tmp_path / "plain", output)
    killed: list[int] = []
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:

        def kill(done: int, total: int) -> None:
            if done and not killed:
                killed.append(next(iter(cluster.workers.values())).pid)
                os.kill(killed[0], signal.SIGKILL)
                assert done < total
                half = tmp_path / "o" / "objects" / f".000000.partial-{killed[0]}"  # as if it had been at that one
                half.mkdir()
                (half / "object.urdf").write_text("<robot")

        write_dataset(job(), tmp_path / "o", output, workers=Workers(cluster=cluster.scheduler_address), progress=kill)
        text = tmp_path / "box.apg"
        text.write_text(STUCK)
        with pytest.raises(NoObject, match="no valid Box"):
            write_dataset(
                open_job(read_request(text)), tmp_path / "p", output, workers=Workers(cluster=cluster.scheduler_address)
            )
    assert killed
    assert tree(tmp_path / "o") == tree(tmp_path / "plain")


def test_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("artipg_dsl.extras.find_spec", lambda name: None)
    with pytest.raises(UserError, match="needs Dask") as caught:
        write_dataset(job(), tmp_path / "o", Output(("annotation",)), workers=Workers(cluster="local"))
    assert "artipg_dsl[cluster]" in caught.value.hint


def test_a_scheduler_that_does_not_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("distributed")
    for command in (["sample"], ["export", "--format", "urdf"]):
        asked = [*command, str(CHEST), "-n", "2", "-o", str(tmp_path / command[0]), "--cluster", "nonsense://x"]
        write_dataset(job(), tmp_path / command[0], Output(("annotation",)), force=True)
        before = tree(tmp_path / command[0])
        assert main([*asked, "--force"]) == 1 and tree(tmp_path / command[0]) == before
        assert "no Dask scheduler answers at nonsense://x" in capsys.readouterr().err


def test_workers_of_a_cluster_elsewhere_are_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["sample", str(CHEST), "-n", "2", "-o", str(tmp_path / "o"), "--cluster", "tcp://head:8786", "--workers"]
    assert main([*asked, "3"]) == 2 and not (tmp_path / "o").exists()
    said = capsys.readouterr().err
    assert "--workers 3 does not apply" in said and "tcp://head:8786 has its own" in said

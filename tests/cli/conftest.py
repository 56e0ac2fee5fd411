import json
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg

from .helpers import CHEST, Apgc


@pytest.fixture
def apgc(capsys: pytest.CaptureFixture[str]) -> Apgc:
    return Apgc(capsys)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as ``apgc fit`` writes it, of two chests whose values are known; beside it the files."""
    from artipg_dsl.export.content import Content
    from artipg_dsl.export.registry import choose_formats
    from artipg_dsl.fit.sources import mark
    from artipg_dsl.run.dataset import write_dataset
    from artipg_dsl.run.output import Output

    folder = tmp_path_factory.mktemp("fitted")
    drawn = [one.drawn for one in apg.sample(CHEST, n=2, seed=4)]
    (folder / "values.jsonl").write_text("".join(json.dumps({"drawn": values}) + "\n" for values in drawn))
    samples = apg.sample(CHEST, values=drawn, seed=4)
    write_dataset(samples.job, folder, Output.of(choose_formats("annotation"), Content()))
    points = samples.points(3000, surface="outside")
    objects = [{"object": None, "name": "tower", "source": "tower.npz", "verdict": "does not fit"}]
    (folder / "fits").mkdir()
    for k in range(2):
        file = folder / f"chest{k}.npz"
        np.savez(file, points=points.position[k], normals=points.normal[k])
        frame = {"up": "z", "front": "x", "unit": "m"}
        record = {"name": f"chest{k}", "frame": frame, "to_object": np.eye(4).tolist(), "file": mark(file)}
        record |= {"drawn": drawn[k]}
        (folder / "fits" / f"chest{k}.json").write_text(json.dumps(record))
        objects.append({"object": k, "name": f"chest{k}", "source": str(file), "verdict": "fits"})
    (folder / "fit.json").write_text(json.dumps({"category": "Chest", "objects": objects}))
    return folder

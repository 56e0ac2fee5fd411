import json
import pickle
from collections.abc import Iterator
from functools import wraps
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import artipg_dsl as apg

from .helpers import CHEST, Apgc


@pytest.fixture
def apgc(capsys: pytest.CaptureFixture[str]) -> Apgc:
    return Apgc(capsys)


@pytest.fixture(scope="module")
def searched_once() -> Iterator[None]:
    """Each cloud is searched once: what is written, read and told of what was found is asked again and again here. That the same is
    found again, test_worn asks."""
    from artipg_dsl.run import fitting

    search, known = fitting.fit, {}

    @wraps(search)
    def fit(model: Any, several: Any, *, opened: Any, doing: Any, **asked: Any) -> Any:
        draws = repr([(d.weights, d.low, d.high) for d in model.program.draws])  # facts leave the hash of a program
        told = pickle.dumps((model.program.hash, draws, several, opened is None, sorted(asked.items())))
        key = blake2b(told).digest()
        if key not in known:
            known[key] = search(model, several, opened=opened, doing=doing, **asked)
        return known[key]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(fitting, "fit", fit)
        yield


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

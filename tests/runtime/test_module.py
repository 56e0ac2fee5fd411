"""The generated module needs NumPy alone and gives the very numbers of the batch."""

import ast
import inspect
import subprocess
import sys
from collections import Counter

import numpy as np

from artipg_dsl import random
from artipg_dsl.runtime import draws, kernels, laws, newton
from artipg_dsl.sampling.module import to_module

CHECK = """
import sys, numpy as np
import made
result = made.sample([3, 37, 5], seed=9)
loaded = {name.split(".")[0] for name in sys.modules}
assert not loaded & {"artipg_dsl", "lark", "scipy", "trimesh", "jinja2"}, loaded
np.savez("out.npz", **{str(k): site["translation"] for k, site in result["sites"].items()})
"""


def test_module_equals_batch(microwave, tmp_path):
    (tmp_path / "made.py").write_text(to_module(microwave.program, "test"), encoding="utf-8")
    (tmp_path / "check.py").write_text(CHECK, encoding="utf-8")
    subprocess.run([sys.executable, "-P", "check.py"], cwd=tmp_path, check=True, env={"PYTHONPATH": str(tmp_path)})
    batch = microwave.batch(np.array([3, 37, 5]), seed=9)
    with np.load(tmp_path / "out.npz") as found:
        assert len(found.files) == len(batch.sites())
        for table in batch.sites():
            assert np.array_equal(found[str(table.number)], table.translation), table.path


def test_what_is_written_into_one_module_has_names_of_its_own():
    """One would take the place of the other, private ones too."""
    defined = Counter(
        name
        for part in (random, laws, kernels, draws, newton)
        for node in ast.parse(inspect.getsource(part)).body
        for name in (
            [node.name]
            if isinstance(node, ast.FunctionDef | ast.ClassDef)
            else [target.id for target in node.targets if isinstance(target, ast.Name)]
            if isinstance(node, ast.Assign)
            else []
        )
    )
    assert len(defined) > 40 and [name for name, count in defined.items() if count > 1] == []

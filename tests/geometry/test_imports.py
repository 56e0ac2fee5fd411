"""What geometry may load (neither the parser nor SciPy, which only a hull needs), and that processes agree."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
MODULES = "agreement block box density hidden mesh patches pieces points sites surface topology trial weld"


def test_geometry_loads_numpy_alone():
    names = ", ".join(f"artipg_dsl.geometry.{m}" for m in MODULES.split())
    heavy = "{'scipy', 'lark', 'trimesh', 'artipg_dsl.syntax', 'artipg_dsl.semantics', 'artipg_dsl.lower'}"
    code = f"import sys, {names}; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_points_are_the_same_bytes_in_processes_with_different_hash_seeds():
    code = (
        "import hashlib, numpy as np; from geometry import scenes, shapes; from artipg_dsl.geometry import points;"
        "from artipg_dsl import random; numbers = np.arange(3, dtype=np.uint64);"
        "made = [shapes.cuboid(), shapes.torus_sector(), shapes.rounded_cuboid()];"
        "found = points.sample(scenes.cluttered(made, numbers, 6), 3, 100, random.key(1, 'p'), numbers);"
        "print(hashlib.sha256(found.position.tobytes() + found.u.tobytes() + found.patch.tobytes()).hexdigest())"
    )
    digests = set()
    for seed in ("1", "2"):
        env = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}"}
        done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
        digests.add(done.stdout.strip())
    assert len(digests) == 1

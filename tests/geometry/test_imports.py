"""What geometry may load: neither the parser nor SciPy, which only a hull needs."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
MODULES = "block box density hidden mesh patches pieces points selftest sites surface topology trial weld"


def test_geometry_loads_numpy_alone():
    names = ", ".join(f"artipg_dsl.geometry.{m}" for m in MODULES.split())
    heavy = "{'scipy', 'lark', 'trimesh', 'artipg_dsl.syntax', 'artipg_dsl.semantics', 'artipg_dsl.lower'}"
    code = f"import sys, {names}; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"

"""The package from outside: what importing it loads, and that a built wheel works alone."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
import venv
from pathlib import Path

import pytest

import artipg_dsl
from artipg_dsl import extras
from artipg_dsl.errors import UserError

ROOT = Path(__file__).parents[1]
HEAVY = {"trimesh", "scipy", "lark", "jinja2", "numpy"}


def loaded_after(code: str) -> set[str]:
    """The top-level modules that are loaded in a fresh process after ``code``."""
    code += "\nimport sys; print('loaded', *{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.splitlines()[-1].split()[1:])


@pytest.mark.parametrize(
    "code",
    [
        "import artipg_dsl; artipg_dsl.__version__; dir(artipg_dsl)",
        "from artipg_dsl.cli.main import main; main(['--help'])",
        "from artipg_dsl.cli.main import main; main(['sample', '--help'])",
        "from artipg_dsl.cli.main import main; main(['--version'])",
    ],
)
def test_importing_and_asking_for_help_load_nothing_heavy(code: str) -> None:
    assert not loaded_after(code) & HEAVY


def test_sampling_tables_loads_no_mesh_library() -> None:
    found = loaded_after("import artipg_dsl; artipg_dsl.sample('Microwave', n=2)['width']")
    assert "numpy" in found and not found & {"trimesh", "jinja2", "moderngl"}


def test_the_public_names_exist() -> None:
    assert set(artipg_dsl.__all__) <= set(dir(artipg_dsl))
    assert all(getattr(artipg_dsl, name) is not None for name in artipg_dsl.__all__)
    with pytest.raises(AttributeError, match="nothing"):
        _ = artipg_dsl.nothing


def test_what_is_missing_is_installed_by_the_extra_that_the_message_names() -> None:
    known = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    for package in (value for value in vars(extras).values() if isinstance(value, extras.Package)):
        assert any(line.startswith(package.module) for line in known[package.extra]), package
    with pytest.raises(UserError) as caught:
        extras.Package("no_such_module", "Nothing", "sim").require("mjcf")
    assert caught.value.message == "mjcf needs Nothing, which is not installed"
    assert caught.value.hint == "pip install 'artipg_dsl[sim]' installs it"


@pytest.mark.skipif("ARTIPG_TEST_WHEEL" not in os.environ, reason="fetches packages; set ARTIPG_TEST_WHEEL=1")
def test_a_wheel_in_an_empty_environment_samples(tmp_path: Path) -> None:
    clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}

    def run(*command: object) -> str:
        done = subprocess.run(
            [*map(str, command)], cwd=tmp_path, env=clean, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    source = tmp_path / "source"
    run("git", "clone", "-q", ROOT, source)
    pip = sys.executable, "-m", "pip"
    run(*pip, "wheel", "-q", "--no-deps", "-w", tmp_path / "wheel", source)
    venv.create(tmp_path / "venv")
    programs = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    wheels = (tmp_path / "wheel").glob("*.whl")
    run(*pip, "--python", programs / "python", "install", "-q", "--no-compile", *wheels)
    assert run(programs / "apgc", "--version") == f"apgc {artipg_dsl.__version__}\n"
    run(programs / "apgc", "sample", "Microwave", "-n", 3, "--points", 64, "--format", "points,urdf,glb", "-o", "out")
    assert (tmp_path / "out" / "objects" / "000002" / "object.urdf").exists()
    assert "site-packages" in run(programs / "python", "-c", "import artipg_dsl; print(artipg_dsl.__file__)")
    run(programs / "apgc", "compile", "Microwave", "-o", "microwave.apgc")
    run(programs / "apgc", "sample", "microwave.apgc", "-n", 1, "--points", 64, "-o", "again")

"""``--backend`` writes the same files either way, and says what is wrong where it cannot be had."""

from pathlib import Path

from artipg_dsl.cli.main import main
from artipg_dsl.native import compiler

from .machine import needs_compiler

CHEST = str(Path(__file__).parents[1] / "cli" / "programs" / "chest.apg")


@needs_compiler
def test_a_run_is_the_same_files_with_either_backend(tmp_path, using):
    for name in ("numpy", "c"):
        assert main(["sample", CHEST, "-n", "3", "--points", "256", "--backend", name, "-o", str(tmp_path / name)]) == 0
    files = {p.relative_to(tmp_path / "c") for p in (tmp_path / "c").rglob("*") if p.is_file()}
    assert len(files) >= 3
    for file in files:
        assert (tmp_path / "c" / file).read_bytes() == (tmp_path / "numpy" / file).read_bytes()


def test_a_backend_that_cannot_be_had_is_an_error(tmp_path, choosing, monkeypatch, capsys):
    monkeypatch.setattr(compiler, "compilers", lambda: [])
    assert main(["sample", CHEST, "-n", "1", "--backend", "c", "-o", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "there is no backend c: there is no C compiler" in said and "--backend numpy" in said
    assert not (tmp_path / "out").exists()


@needs_compiler
def test_profile_says_which_backend_it_measures(using, capsys):
    assert main(["profile", CHEST, "-n", "2", "--backend", "c"]) == 0
    assert "backend c" in capsys.readouterr().out

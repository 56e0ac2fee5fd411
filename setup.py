"""Puts the top-level folders that a category needs at run time into the wheel; all else is in pyproject.toml."""

from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

SHIPPED = {"grammar": "*.lark", "library": "*.apg", "categories": "*.apg"}


class BuildWithData(build_py):
    """Copies them to ``artipg_dsl/_data``; an editable install reads them where they are."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        for source, target in self._shipped():
            self.mkpath(str(Path(target).parent))
            self.copy_file(source, target)

    def _shipped(self) -> list[tuple[str, str]]:
        data = Path(self.build_lib, "artipg_dsl", "_data")
        return [
            (str(path), str(data / folder / path.name))
            for folder, pattern in SHIPPED.items()
            for path in sorted(Path(folder).glob(pattern))
        ]

    def get_outputs(self, include_bytecode: bool = True) -> list[str]:
        return [*super().get_outputs(include_bytecode), *(target for _, target in self._shipped())]


setup(cmdclass={"build_py": BuildWithData})

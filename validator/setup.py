"""Build step that brings the registry of requirements and the schemas into the distribution.

They live once, in ``spec/`` and ``schema/`` of the repository. A source distribution carries them in
``tilesnav_validator/data`` already, since the same step runs before it is packed.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).resolve().parent
DATA = Path("tilesnav_validator", "data")


def sources() -> list[Path]:
    """Files of the registry and the schemas: from the repository, or from an unpacked source distribution."""
    repository = HERE.parent
    if (repository / "spec" / "requirements.toml").is_file():
        return [
            repository / "spec" / "requirements.toml",
            *sorted((repository / "schema").glob("*.schema.json")),
        ]
    files = sorted((HERE / DATA).glob("*"))
    if not any(path.name == "requirements.toml" for path in files):
        raise FileNotFoundError(
            "spec/requirements.toml is neither beside this folder nor in tilesnav_validator/data"
        )
    return files


def copy_into(folder: Path) -> None:
    """Copy the files of ``sources`` into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in sources():
        if path.parent != folder:
            shutil.copyfile(path, folder / path.name)


class BuildWithData(build_py):
    """``build_py`` that adds the data files to what is built."""

    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            copy_into(Path(self.build_lib) / DATA)


class SdistWithData(sdist):
    """``sdist`` that adds the data files to the release tree."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        super().make_release_tree(base_dir, files)
        copy_into(Path(base_dir) / DATA)


setup(cmdclass={"build_py": BuildWithData, "sdist": SdistWithData})

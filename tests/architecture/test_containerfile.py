"""The Containerfile: its instructions are known, and what it copies is enough to build the package."""

from __future__ import annotations

import json
import re
import shutil
import tomllib
import zipfile
from pathlib import Path

from architecture.test_distributions import REPOSITORY, build

FILE = (REPOSITORY / "Containerfile").read_text()
ARGUMENTS = {"FROM", "WORKDIR", "COPY", "RUN", "USER", "ENV", "ENTRYPOINT", "CMD"}


def instructions() -> list[tuple[str, str]]:
    """Return the instructions with their arguments."""
    lines = [line for line in FILE.splitlines() if line and not line.startswith("#")]
    return [
        (words[0], words[1])
        for line in "\n".join(lines).replace("\\\n", " ").splitlines()
        if len(words := line.split(maxsplit=1)) == 2
    ]


def test_instructions_name_what_the_package_has() -> None:
    found = instructions()
    assert {name for name, _ in found} == ARGUMENTS
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    (extras,) = re.findall(r"\.whl\)\[([\w,]+)\]", FILE)
    assert set(extras.split(",")) <= project["optional-dependencies"].keys()
    (entry,) = [json.loads(words) for name, words in found if name == "ENTRYPOINT"]
    assert entry[0] in project["scripts"]


def test_the_copied_files_build_the_package(tmp_path: Path) -> None:
    source = tmp_path / "source"
    source.mkdir()
    for name, words in instructions():
        if name == "COPY" and not words.startswith("--from"):
            *paths, target = words.split()
            for path in paths:
                if (REPOSITORY / path).is_dir():
                    shutil.copytree(
                        REPOSITORY / path, source / target, ignore=shutil.ignore_patterns("__pycache__")
                    )
                else:
                    shutil.copy(REPOSITORY / path, source / target)
    names = zipfile.ZipFile(build(source, "wheel", tmp_path)).namelist()
    assert "rostether/__main__.py" in names
    assert any(name.startswith("rostether/client/src/ros/") for name in names)

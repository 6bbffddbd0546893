"""The Containerfile: its instructions are known, and what it copies is enough to build the package."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
PYPROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())
FILE = (REPOSITORY / "Containerfile").read_text()
ARGUMENTS = {"FROM", "WORKDIR", "COPY", "RUN", "USER", "ENV", "ENTRYPOINT", "CMD"}


def instructions() -> list[tuple[str, str]]:
    """Return the instructions with their arguments."""
    lines = [line for line in FILE.splitlines() if line and not line.startswith("#")]
    return [
        (parts[0], parts[1])
        for line in "\n".join(lines).replace("\\\n", " ").splitlines()
        if len(parts := line.split(maxsplit=1)) == 2
    ]


def test_instructions_use_extras_and_commands_of_the_package() -> None:
    found = instructions()
    assert {name for name, _ in found} == ARGUMENTS
    project = PYPROJECT["project"]
    (extras,) = re.findall(r"\.whl\)\[([\w,]+)\]", FILE)
    assert set(extras.split(",")) <= project["optional-dependencies"].keys()
    (entry,) = [json.loads(text) for name, text in found if name == "ENTRYPOINT"]
    assert entry[0] in project["scripts"]


def test_all_files_of_the_build_are_copied() -> None:
    copied: set[str] = set()
    for name, text in instructions():
        if name == "COPY" and not text.startswith("--from"):
            copied.update(text.split()[:-1])
    assert all((REPOSITORY / each).exists() for each in copied)
    readme = PYPROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]["fragments"]
    wheel = PYPROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]
    expected = {"pyproject.toml", *(each["path"] for each in readme), *wheel["force-include"]}
    expected |= {each.partition("/")[0] for each in PYPROJECT["project"]["license-files"]}
    expected |= {each.partition("/")[0] for each in wheel["packages"]}
    assert expected <= copied

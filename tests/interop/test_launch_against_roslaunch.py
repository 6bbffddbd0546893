"""Debian's roslaunch and rostether read a corpus of launch files with the same results: parameters, nodes,
remaps, environments, errors.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from interop.ros1_peers import DEBIAN_PYTHON, ros_environment
from unit.launch.corpus import (
    ENVIRON,
    FOLDER,
    RIGHT,
    WRONG,
    described,
    exact,
    expected,
    given_words,
    load,
    neutral,
)

ORACLE = Path(__file__).parent / "peers" / "roslaunch_oracle.py"


def ask_roslaunch(home: Path) -> dict[str, Any]:
    environment = ros_environment("http://localhost:11311", home) | ENVIRON
    environment["ROS_PACKAGE_PATH"] = str(FOLDER)
    cases = [{"file": str(file), "argv": ["roslaunch", *given_words(file)]} for file in (*RIGHT, *WRONG)]
    completed = subprocess.run(
        [DEBIAN_PYTHON, str(ORACLE)],
        input=json.dumps(cases),
        capture_output=True,
        text=True,
        env=environment,
        cwd=home,
        check=False,
    )
    assert completed.returncode == 0, completed.stderr
    return {
        file.stem: neutral(result)
        for file, result in zip((*RIGHT, *WRONG), json.loads(completed.stdout), strict=True)
    }


@pytest.fixture(scope="module")
def roslaunch(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return ask_roslaunch(tmp_path_factory.mktemp("home"))


@pytest.mark.parametrize("file", RIGHT, ids=lambda file: file.stem)
def test_plan_is_that_of_roslaunch(file: Path, roslaunch: dict[str, Any]) -> None:
    expected_plan = roslaunch[file.stem]
    expected_plan.pop("warnings", None)
    assert exact(described(load(file))) == exact(expected_plan)


def test_recorded_vectors_equal_the_output_of_roslaunch(roslaunch: dict[str, Any]) -> None:
    recorded = expected()
    assert recorded.keys() == {file.stem for file in RIGHT}
    reported = {name: {**roslaunch[name]} for name in recorded}
    for result in reported.values():
        result.pop("warnings", None)
    assert exact(recorded) == exact(reported)


@pytest.mark.parametrize("file", WRONG, ids=lambda file: file.stem)
def test_roslaunch_refuses_the_same_files(file: Path, roslaunch: dict[str, Any]) -> None:
    assert "error" in roslaunch[file.stem]

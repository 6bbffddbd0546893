"""The page's tf buffer compared with tf2: the same transforms give the same poses."""

from __future__ import annotations

import json
import math
import os
import random
import subprocess
import sys
from pathlib import Path
from typing import cast

import pytest

from interop.ros1_peers import ros_environment

PEERS = Path(__file__).parent / "peers"
SCENE = Path(__file__).parents[2] / "web/src/scene"
FRAMES = [("map", "odom"), ("odom", "base"), ("base", "arm"), ("arm", "hand"), ("base", "laser")]


def make_script(source: random.Random) -> str:
    transforms = []
    for parent, child in FRAMES:
        is_static = child == "laser"
        for step in range(1 if is_static else 40):
            rotation = [source.gauss(0, 1) for _ in range(4)]
            length = math.hypot(*rotation)
            translation = [source.uniform(-2, 2) for _ in range(3)]
            time_s = 100 + step * 0.1 + source.uniform(0, 0.05)
            transforms.append(
                [parent, child, time_s, *translation, *(each / length for each in rotation), is_static]
            )
    names = ["map", *(child for _, child in FRAMES)]
    lookups = [[*source.sample(names, 2), 100 + source.uniform(0.2, 3.8)] for _ in range(50)]
    return json.dumps({"transforms": transforms, "lookups": lookups})


@pytest.mark.robot
def test_lookups_are_those_of_tf2(tmp_path: Path) -> None:
    script = make_script(random.Random(7))

    def run(command: list[str], environment: dict[str, str]) -> list[list[float]]:
        completed = subprocess.run(
            command, env=environment, input=script, capture_output=True, text=True, check=True
        )
        return cast("list[list[float]]", json.loads(completed.stdout))

    environment = ros_environment("http://127.0.0.1:1", tmp_path)
    expected = run(["/usr/bin/python3", str(PEERS.parents[1] / "interop/peers/tf2_lookups.py")], environment)
    # Node of the development packages: it reads TypeScript.
    node = str(Path(sys.executable).parent / "node")
    found = run([node, "--no-warnings", str(PEERS / "tf_buffer_lookups.mts"), str(SCENE)], dict(os.environ))
    assert len(found) == len(expected) == 50
    for page_pose, tf2_pose in zip(found, expected, strict=True):
        assert page_pose[:3] == pytest.approx(tf2_pose[:3], abs=1e-6)
        # A rotation and its negative are the same.
        sign = math.copysign(1, sum(a * b for a, b in zip(page_pose[3:], tf2_pose[3:], strict=True)))
        assert [sign * each for each in page_pose[3:]] == pytest.approx(tf2_pose[3:], abs=1e-6)

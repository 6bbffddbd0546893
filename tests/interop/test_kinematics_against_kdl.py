"""Joints at right angles, where the last bit decides the sign of a quaternion: it is the same as with KDL."""

from __future__ import annotations

import itertools
import json
import math
import subprocess
from pathlib import Path

import pytest

from interop.ros1_peers import DEBIAN_PYTHON
from rostether.robot.robot_model import Joint, JointType
from rostether.robot.robot_state import joint_transform
from rostether.robot.transform import Transform, quaternion_from_rpy

pytestmark = pytest.mark.robot

PEER = Path(__file__).parent / "peers" / "kdl_joint.py"
TOLERANCE = 1e-9

ORIGIN_ANGLES = (0.0, math.pi / 2, -math.pi / 2, math.pi, -math.pi, 1.57, 1.5708, math.pi / 4)
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 1.0, 1.0), (0.0, 3.0, 4.0))
POSITIONS = (0.0, math.pi / 2, math.pi, 2 * math.pi / 3, -1.57)


def test_signs_of_quaternions_equal_those_of_kdl() -> None:
    joints = [
        Joint(
            "joint",
            JointType.REVOLUTE,
            "parent",
            "child",
            Transform((0.1, 0.2, 0.3), quaternion_from_rpy(*rpy)).normalized(),
            axis,
        )
        for rpy in itertools.product(ORIGIN_ANGLES, repeat=3)
        for axis in AXES
    ]
    cases = [(joint, position) for joint in joints for position in POSITIONS]
    request = json.dumps([[joint.origin.rotation, joint.axis, position] for joint, position in cases])
    completed = subprocess.run(
        [DEBIAN_PYTHON, str(PEER)], input=request, capture_output=True, text=True, check=True, timeout=60
    )
    differing = [
        (joint.origin.rotation, joint.axis, position)
        for (joint, position), expected in zip(cases, json.loads(completed.stdout), strict=True)
        if any(
            abs(a - b) > TOLERANCE
            for a, b in zip(joint_transform(joint, position).rotation, expected, strict=True)
        )
    ]
    assert differing == []

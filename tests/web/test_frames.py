"""The positions of frames on the page, compared with Debian's tf2."""

from __future__ import annotations

import asyncio
import json
import math
import random
import subprocess
from pathlib import Path

import pytest

import rostether
from interop.ros1_peers import ros_environment
from web.browser import Browser
from web.robot import POLL_S, TIMEOUT_S, Robot

pytestmark = [pytest.mark.asyncio(loop_scope="session"), pytest.mark.robot]

LOOKUPS = Path(__file__).parents[1] / "interop/peers/tf2_lookups.py"
CHAIN = [("odom", "arm"), ("arm", "hand"), ("hand", "finger")]
POSES = 10


def random_pose(source: random.Random) -> list[float]:
    rotation = [source.gauss(0, 1) for _ in range(4)]
    length = math.hypot(*rotation)
    return [source.uniform(-1, 1) for _ in range(3)] + [each / length for each in rotation]


async def test_ten_poses_are_drawn_as_tf2_computes_them(
    robot: Robot, browser: Browser, tmp_path: Path
) -> None:
    source = random.Random(5)
    steps = [[(*names, random_pose(source)) for names in CHAIN] for _ in range(POSES)]
    script = {
        "transforms": [
            [parent, child, 100 + step, *pose, False]
            for step, poses in enumerate(steps)
            for parent, child, pose in poses
        ],
        "lookups": [["odom", "finger", 100 + step] for step in range(POSES)],
    }
    completed = subprocess.run(
        ["/usr/bin/python3", str(LOOKUPS)],
        env=ros_environment("http://127.0.0.1:1", tmp_path),
        input=json.dumps(script),
        capture_output=True,
        text=True,
        check=True,
    )
    page = await browser.do("open", url=robot.url + "#/scene")
    drawn = "document.querySelector('.page-scene canvas')?.axesAt('finger')"
    async with rostether.join("broadcaster", master=robot.master) as graph:
        publisher = await graph.publisher("/tf", "tf2_msgs/TFMessage")
        await browser.wait_for(page, "document.querySelector('.scene-side select') !== null")
        for poses, expected in zip(steps, json.loads(completed.stdout), strict=True):
            # A rotation and its negative are the same.
            near = (
                f"((at, to) => at && [1, -1].some((sign) => at.every((each, index) => "
                f"Math.abs((index < 3 ? each : sign * each) - to[index]) < 1e-6)))({drawn}, {expected})"
            )
            async with asyncio.timeout(TIMEOUT_S):
                while not await browser.do("evaluate", page=page, script=near):
                    now = graph.now()
                    publisher.publish(transforms=[transform(*each, now) for each in poses])
                    await asyncio.sleep(POLL_S)


async def test_static_frames_of_several_nodes_are_shown_after_the_graph(
    robot: Robot, browser: Browser
) -> None:
    async with (
        rostether.join("front_node", master=robot.master) as front,
        rostether.join("rear_node", master=robot.master) as rear,
    ):
        for graph, child in ((front, "front_camera"), (rear, "rear_camera")):
            publisher = await graph.publisher("/tf_static", "tf2_msgs/TFMessage", latch=True)
            publisher.publish(transforms=[transform("arm", child, [0, 0, 0, 0, 0, 0, 1], graph.now())])
        # This panel receives all topics, and shares its subscriptions with the next panel.
        page = await browser.do("open", url=robot.url + "#/graph")
        await browser.wait_for(page, "rostether.feed('/tf_static').last !== undefined")
        await browser.do("evaluate", page=page, script="void (location.hash = '#/frames')")
        for child in ("front_camera", "rear_camera"):
            await browser.wait_for(page, f"document.body.innerText.includes('{child}')")


def transform(parent: str, child: str, pose: list[float], stamp: object) -> dict[str, object]:
    x, y, z, qx, qy, qz, qw = pose
    return {
        "header": {"frame_id": parent, "stamp": stamp},
        "child_frame_id": child,
        "transform": {
            "translation": {"x": x, "y": y, "z": z},
            "rotation": {"x": qx, "y": qy, "z": qz, "w": qw},
        },
    }

"""The sensors of the device that shows the page, as topics; the browser simulates the sensors."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

import rostether
from web.browser import CHROMIUM, Browser
from web.robot import TIMEOUT_S, Robot

pytestmark = pytest.mark.asyncio(loop_scope="session")

# The phone lies on a table, with its top to the west, and turns to the left.
READINGS = {
    "accelerometer": {"xyz": {"x": 0, "y": 0, "z": 9.81}},
    "linear-acceleration": {"xyz": {"x": 0, "y": 0, "z": 0}},
    "gyroscope": {"xyz": {"x": 0, "y": 0, "z": 0.5}},
    "absolute-orientation": {"quaternion": {"x": 0, "y": 0, "z": 0.5**0.5, "w": 0.5**0.5}},
    "relative-orientation": {"quaternion": {"x": 0, "y": 0, "z": 0.5**0.5, "w": 0.5**0.5}},
}
TOPICS = {
    "Motion": ("/phone/imu", "sensor_msgs/Imu"),
    "Position": ("/phone/fix", "sensor_msgs/NavSatFix"),
    "Camera": ("/phone/camera/compressed", "sensor_msgs/CompressedImage"),
    "Battery": ("/phone/battery", "sensor_msgs/BatteryState"),
}
SETS_THE_NAME = "localStorage['rostether.phone.name'] = JSON.stringify('phone')"


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def browser(packages: Path) -> AsyncIterator[Browser]:
    """Chromium with a camera."""
    browser = await Browser.start(packages, CHROMIUM)
    yield browser
    await browser.close()


async def first(messages: AsyncIterator[Any]) -> Any:
    """Return the first message; for motion, the first after the browser has reported the attitude."""
    async for message in messages:
        if not hasattr(message, "orientation") or message.orientation_covariance[0] == 0:
            return message
    raise AssertionError("the topic has ended")


def switch(name: str) -> str:
    return f".phone [role=switch][aria-label={name}]"


async def test_a_phone_publishes_its_sensors_in_the_robot_s_time(robot: Robot, browser: Browser) -> None:
    page = await browser.do(
        "open",
        url=robot.url + "#/phone",
        script=SETS_THE_NAME,
        permissions=["camera", "geolocation", "accelerometer", "gyroscope", "magnetometer"],
        geolocation={"latitude": 48.1, "longitude": 11.5, "accuracy": 9.8},
    )
    await browser.do("sense", page=page, readings=READINGS)
    async with rostether.join("probe", master=robot.master) as graph, asyncio.timeout(TIMEOUT_S):
        first_messages = [
            asyncio.ensure_future(first(graph.messages(topic, kind))) for topic, kind in TOPICS.values()
        ]
        for name in TOPICS:
            await browser.do("click", page=page, selector=switch(name))
        imu, fix, picture, battery = await asyncio.gather(*first_messages)
        for message in (imu, picture, battery):
            stamp = message.header.stamp
            # Both clocks are those of this machine, which may be busy.
            assert abs(time.time() - stamp.secs - stamp.nsecs / 1e9) < TIMEOUT_S
        assert imu.header.frame_id == "phone"
        assert imu.linear_acceleration.z == pytest.approx(9.81, abs=0.1)
        assert imu.angular_velocity.z == pytest.approx(0.5, abs=0.01)
        assert imu.orientation.z == pytest.approx(math.sqrt(0.5), abs=0.01)
        assert (fix.latitude, fix.longitude) == (48.1, 11.5)
        assert fix.position_covariance[0] == pytest.approx(25.0)
        assert bytes(picture.data[:3]) == b"\xff\xd8\xff"
        assert picture.header.frame_id == "phone_camera"
        assert battery.present
        # A hidden page publishes nothing.
        await browser.do("hide", page=page, hidden=True)
        await robot.wait_for_publication("/phone/imu", expected=False)
        await browser.do("hide", page=page, hidden=False)
        await robot.wait_for_publication("/phone/imu", expected=True)
    assert (await browser.do("seen", page=page))["errors"] == []


async def test_a_denied_sensor_is_explained(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/phone", permissions=[])
    for name in ("Position", "Motion", "Camera"):
        await browser.do("click", page=page, selector=switch(name))
        await browser.wait_for(page, f"document.body.innerText.includes('{name} is blocked in this browser')")
    on = "document.querySelectorAll('.phone [aria-checked=true]').length"
    await browser.wait_for(page, f"{on} === 0")

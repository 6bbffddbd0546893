"""The robots of a fleet and their sensors on the page."""

from __future__ import annotations

import pytest

from web.browser import Browser
from web.robot import Robot
from web.sensing_fleet import sensing_fleet

pytestmark = pytest.mark.asyncio(loop_scope="module")


def text(selector: str) -> str:
    return f"(document.querySelector({selector!r})?.innerText ?? '')"


async def test_robots_and_their_sensors_are_shown(robot: Robot, browser: Browser) -> None:
    async with sensing_fleet(robot.master, robots=2, cameras=1):
        page = await browser.do("open", url=robot.url + "#/fleet", width=390, touch=True)
        await browser.wait_for(page, f"{text('.fleet-count')} === '2 robots answer'")
        await browser.do("click", page=page, selector=".fleet-stop")
        await browser.wait_for(page, f"{text('.fleet-answer')} === '2 robots confirmed'")

        page = await browser.do("open", url=robot.url + "#/sensors", width=390, touch=True)
        await browser.do("fill", page=page, selector=".sensors input", text="robot 2 range")
        await browser.wait_for(page, "document.querySelectorAll('.sensors-platform').length === 0")
        await browser.do("fill", page=page, selector=".sensors input", text="robot 2 distance")
        await browser.do("click", page=page, selector=".sensor[title='/sensors/robot2/distance']")
        await browser.wait_for(page, f"/^2\\.\\d+ m$/.test({text('.sensor-number')})")
        await browser.do("fill", page=page, selector=".sensors input", text="robot 1 camera ready")
        await browser.do("click", page=page, selector=".sensor[title='/sensors/robot1/camera']")
        await browser.wait_for(page, "document.querySelector('.sensor-pane canvas')?.width === 320")
        assert (await browser.do("seen", page=page))["errors"] == []

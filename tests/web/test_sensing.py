"""The robots of a fleet, and their sensors, on the page."""

from __future__ import annotations

import asyncio
import signal
from pathlib import Path

import pytest

from web.browser import Browser
from web.robot import Robot, end, run_rostether
from web.sensing_fleet import sensing_fleet

pytestmark = pytest.mark.asyncio(loop_scope="session")


ROWS = "document.querySelectorAll('.sensor').length"
BATTERY = "document.querySelector(\".sensor[title='/sensors/robot2/battery'] .badge\")?.textContent"


def text(selector: str) -> str:
    return f"(document.querySelector({selector!r})?.innerText ?? '')"


class SensingManager:
    """The process of a sensing manager, which can be killed."""

    def __init__(self, robot: Robot, folder: Path) -> None:
        self._robot = robot
        self._folder = folder
        self._process: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        """Start it; it stores its sensors in a file."""
        file = self._folder / "sensors.json"
        self._process = await run_rostether(
            self._folder, self._robot.master, "role", "sensing-manager", f"_state_file:={file}"
        )

    async def end(self, number: signal.Signals) -> None:
        """End it with a signal."""
        await end(self._process, number)


async def test_robots_and_their_sensors_are_shown(robot: Robot, browser: Browser, tmp_path: Path) -> None:
    manager = SensingManager(robot, tmp_path)
    await manager.start()
    async with sensing_fleet(robot.master, robots=2, cameras=1, has_manager=False) as sensors:
        page = await browser.do("open", url=robot.url + "#/fleet", width=390, touch=True)
        await browser.wait_for(page, f"{text('.fleet-count')} === '2 robots answer'")
        await browser.do("click", page=page, selector=".fleet-stop")
        await browser.wait_for(page, f"{text('.fleet-answer')} === '2 robots confirmed the stop'")

        page = await browser.do("open", url=robot.url + "#/sensors", width=390, touch=True)
        await browser.do("fill", page=page, selector=".sensors input", text="robot 2 range")
        await browser.wait_for(page, "document.querySelectorAll('.sensors-platform').length === 0")
        await browser.do("fill", page=page, selector=".sensors input", text="robot 2 distance")
        await browser.do("click", page=page, selector=".sensor[title='/sensors/robot2/distance']")
        await browser.wait_for(page, f"/^2\\.\\d+ m$/.test({text('.sensor-number')})")
        await browser.do("fill", page=page, selector=".sensors input", text="robot 1 camera ready")
        await browser.do("click", page=page, selector=".sensor[title='/sensors/robot1/camera']")
        await browser.wait_for(page, "document.querySelector('.sensor-pane canvas')?.width === 320")

        # After the manager is killed, the tree and the values stay, and the restarted manager shows a
        # change.
        await browser.do("fill", page=page, selector=".sensors input", text="")
        await browser.wait_for(page, f"{ROWS} === 9 && {BATTERY} === 'Ready'")
        await manager.end(signal.SIGKILL)
        (battery,) = [each for each in sensors if each.description.id == "robot2/battery"]
        battery.set_state("alert", "low")
        before = await browser.do("evaluate", page=page, script=text(".sensor-number"))
        await browser.wait_for(page, f"{text('.sensor-number')} !== '{before}'")
        assert await browser.do("evaluate", page=page, script=ROWS) == 9
        assert await browser.do("evaluate", page=page, script=BATTERY) == "Ready"
        await manager.start()
        await browser.wait_for(page, f"{BATTERY} === 'Alert'")
        assert await browser.do("evaluate", page=page, script=ROWS) == 9
        assert (await browser.do("seen", page=page))["errors"] == []
    await manager.end(signal.SIGTERM)

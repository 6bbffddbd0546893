"""A robot with meshes in 3D, and the sliders of its joints."""

from __future__ import annotations

import math
import struct
from collections import Counter
from pathlib import Path

import pytest
from PIL import Image

from web.browser import Browser
from web.meshed_robot import write_robot
from web.robot import LaunchedRobot

pytestmark = pytest.mark.asyncio(loop_scope="session")

SLIDERS = "/joint_state_publisher_gui/sliders"
WHEEL = "rostether.feed('/tf').lastMessage()?.transforms.find((each) => each.child_frame_id === 'wheel')"


async def test_meshes_are_drawn_and_sliders_move_them(tmp_path: Path, browser: Browser) -> None:
    async with LaunchedRobot(tmp_path, write_robot(tmp_path / "packages")) as robot:
        page = await browser.do("open", url=robot.url + "#/scene")
        await browser.wait_for(page, "document.querySelectorAll('.scene-side input').length > 1")
        before = await _wait_for_colors(browser, page, tmp_path / "robot.png")
        assert (await browser.do("text", page=page, selector=".scene-side")).count("mesh") == 0
        await browser.do("evaluate", page=page, script="void rostether.subscribe('/tf')")
        await browser.do("evaluate", page=page, script="void (location.hash = '#/controls')")
        slider = "document.querySelector('.joint input')"
        # Until the publisher of the sliders runs, /joint_states has sliders.
        shown = "document.querySelector('.controls-grid')?.textContent"
        await browser.wait_for(page, f"{shown}?.includes({SLIDERS!r}) && {slider} !== null")
        move = f"{slider}.value = 1; void {slider}.dispatchEvent(new Event('input', {{ bubbles: true }}))"
        await browser.do("evaluate", page=page, script=move)
        await browser.wait_for(page, f"{WHEEL}?.transform.rotation.y > 0.4")
        rotation = (await browser.do("evaluate", page=page, script=WHEEL))["transform"]["rotation"]
        angle = 2 * math.atan2(rotation["y"], rotation["w"])
        # The slider has 500 steps from -3.14 to 3.14.
        assert angle == pytest.approx(1, abs=0.01)
        await browser.do("evaluate", page=page, script="void (location.hash = '#/scene')")
        after = await _wait_for_colors(browser, page, tmp_path / "moved.png")
        assert after != before
        await browser.do("click", page=page, selector=".header .icon-button")
        await _wait_for_background(browser, page, tmp_path / "dark.png", 0x14)
        assert (await browser.do("seen", page=page))["errors"] == []


async def _wait_for_background(browser: Browser, page: int, path: Path, red: int) -> None:
    """Wait until the background of the picture has this value of red."""
    for _ in range(600):
        await browser.do("screenshot", page=page, path=str(path))
        with Image.open(path) as picture:
            if picture.convert("RGB").crop((600, 120, 601, 121)).tobytes()[0] == red:
                return
    raise AssertionError(f"the background is not {red}")


async def _wait_for_colors(browser: Browser, page: int, path: Path) -> tuple[int, ...]:
    """Return the numbers of pixels in the STL file's gray, the Collada file's red and the OBJ file's
    green.
    """
    for _ in range(600):
        # Only a picture shows what is drawn.
        await browser.do("screenshot", page=page, path=str(path))
        counts = [0, 0, 0]
        with Image.open(path) as picture:
            # Without the text of the list, which is also gray.
            drawing = picture.convert("RGB").crop((220, 120, 980, 800))
        for (red, green, blue), count in Counter(struct.iter_unpack("3B", drawing.tobytes())).items():
            if red > 100 and green < 60 and blue < 60:
                counts[1] += count
            elif green > 100 and red < 60 and blue < 60:
                counts[2] += count
            elif max(red, green, blue) - min(red, green, blue) < 15 and 100 < red < 215:
                counts[0] += count
        if min(counts) > 500:
            return tuple(counts)
    raise AssertionError(f"gray, red and green pixels: {counts}")

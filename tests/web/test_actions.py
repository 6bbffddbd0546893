"""Actions on the page reach the robot, and stop with the page."""

from __future__ import annotations

import asyncio
import base64
import json

import pytest

import rostether
from web.browser import TIMEOUT_S, Browser
from web.robot import Robot

pytestmark = pytest.mark.asyncio(loop_scope="session")

LED = "rostether.feed('/led').lastMessage()?.data"


async def test_a_tap_toggles_the_led(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/controls")
    await browser.do("evaluate", page=page, script="void rostether.subscribe('/led')")
    await browser.wait_for(page, f"{LED} !== undefined")
    before = await browser.do("evaluate", page=page, script=LED)
    await browser.do("click", page=page, selector=".push")
    await browser.wait_for(page, f"{LED} === {str(not before).lower()}")


async def test_a_switch_calls_a_service(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/controls")
    switch = '.switch[aria-label="/set_led"]'
    await browser.wait_for(page, f"document.querySelector({switch!r}) !== null")
    state = f"document.querySelector({switch!r}).getAttribute('aria-checked')"
    assert await browser.do("evaluate", page=page, script=state) == "mixed"
    await browser.do("click", page=page, selector=switch)
    await browser.wait_for(page, "document.querySelector('.controls-grid').innerText.includes('LED on')")
    await browser.wait_for(page, f"{state} === 'true'")


async def test_controls_follow_another_page(robot: Robot, browser: Browser) -> None:
    async with rostether.join("controlled", master=robot.master) as graph:
        switch = await graph.subscriber("/switch", "std_msgs/Bool", lambda _: None)
        counter = await graph.subscriber("/far", "std_msgs/Int64", lambda _: None)
        first, second = [await browser.do("open", url=robot.url + "#/controls") for _ in range(2)]
        selector = '.switch[aria-label="/switch"]'
        state = f"document.querySelector({selector!r})?.getAttribute('aria-checked')"
        box = "document.querySelector('.control-card:has([aria-label=\"/far\"]) .slider-value')"
        # The highest integer of 64 bits has more digits than a number of JavaScript.
        enter = f"{box}.value = '9223372036854775807'; {box}.dispatchEvent(new Event('change'))"
        for page in (first, second):
            await browser.wait_for(page, f"{state} === 'mixed' && {box} !== null")
        async with asyncio.timeout(TIMEOUT_S):
            # Messages are lost until the robot has connected the topic to the pages.
            while await browser.do("evaluate", page=second, script=state) == "mixed":
                await browser.do("click", page=first, selector=selector)
                await asyncio.sleep(0.1)
            while await browser.do("evaluate", page=first, script=f"{box}.value") != "9223372036854775807":
                await browser.do("evaluate", page=second, script=enter)
                await asyncio.sleep(0.1)
        expected = "false" if await browser.do("evaluate", page=first, script=state) == "true" else "true"
        await browser.do("click", page=first, selector=selector)
        await browser.wait_for(second, f"{state} === {expected!r}")
        await browser.wait_for(first, f"{state} === {expected!r}")
        await switch.close()
        await counter.close()


async def test_a_card_and_its_page_share_the_range_of_a_slider(robot: Robot, browser: Browser) -> None:
    async with rostether.join("servo", master=robot.master) as graph:
        servo = await graph.subscriber("/servo", "std_msgs/UInt16", lambda _: None)
        # A link may contain anything.
        damaged = robot.url + "#/controls?s=" + base64.b64encode(b'{"topic": 5, "ranges": "x"}').decode()
        page = await browser.do("open", url=damaged)
        slider = ".querySelector('[type=range][aria-label=\"/servo\"]')"
        await browser.wait_for(page, f"document{slider} !== null")
        await browser.do("evaluate", page=page, script="void (location.hash = '#/')")
        await browser.do(
            "click", page=page, selector=".card-controls .card-head a[href*='?s=']:has-text('/servo')"
        )
        # The page of one panel still has the other controls.
        await browser.wait_for(
            page,
            f"!document.querySelector('.cards') && document{slider}"
            " && document.querySelectorAll('.control').length > 1",
        )
        await browser.do("fill", page=page, selector=".slider [aria-label='Highest value']", text="90")
        await browser.do("evaluate", page=page, script="document.activeElement.blur()")
        await browser.do("evaluate", page=page, script="void (location.hash = '#/')")
        await browser.wait_for(page, f"document.querySelector('.cards')?{slider}?.max === '90'")
        saved = await browser.do("evaluate", page=page, script="localStorage['rostether.panel.controls']")
        assert json.loads(saved) == {"ranges": {"/servo": {"min": 0, "max": 90}}}
        await servo.close()


async def test_the_robot_stops_when_the_tab_is_closed(robot: Robot, browser: Browser) -> None:
    async with rostether.join("driven", master=robot.master) as graph:
        commands: list[float] = []

        async def follow() -> None:
            async for message in graph.messages("/cmd_vel", "geometry_msgs/Twist"):
                commands.append(message.linear.x)

        following = asyncio.ensure_future(follow())
        page = await browser.do("open", url=robot.url + "#/drive")
        await browser.wait_for(page, "document.querySelector('.stick-pad') !== null")
        press = "void dispatchEvent(new KeyboardEvent('keydown', { code: 'KeyW' }))"
        async with asyncio.timeout(TIMEOUT_S):
            while not commands or commands[-1] <= 0:
                # The page handles keys shortly after it is drawn.
                await browser.do("evaluate", page=page, script=press)
                await asyncio.sleep(0.1)
        await browser.do("close", page=page)
        async with asyncio.timeout(TIMEOUT_S):
            while commands[-1] != 0:
                await asyncio.sleep(0.02)
        assert max(commands) <= 0.3
        following.cancel()


async def test_the_letter_keys_drive_after_a_slider_was_moved(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/drive")
    async with rostether.join("driven", master=robot.master) as graph:
        await graph.subscriber("/cmd_vel", "geometry_msgs/Twist", lambda _: None)
        await browser.wait_for(page, "document.querySelector('.drive-state')?.innerText.startsWith('Ready')")

        async def press(code: str) -> None:
            event = f"new KeyboardEvent('keydown', {{ code: '{code}', bubbles: true }})"
            script = f"void document.querySelector('main input[type=range]').dispatchEvent({event})"
            await browser.do("evaluate", page=page, script=script)

        speed = "document.querySelector('main').innerText.match(/-?[0-9.]+ m.s/)[0]"
        await press("ArrowUp")
        assert await browser.do("evaluate", page=page, script=speed) == "0.00 m/s"
        await press("KeyW")
        await browser.wait_for(page, f"{speed} === '0.30 m/s'")
        await press("Space")
        await browser.wait_for(page, f"{speed} === '0.00 m/s'")


async def test_a_recording_is_made_listed_and_played(robot: Robot, browser: Browser) -> None:
    page = await browser.do("open", url=robot.url + "#/recording")
    await browser.do("click", page=page, selector=".recording .primary")
    await browser.wait_for(
        page, "/[1-9]\\d* messages/.test(document.querySelector('.recording-state').innerText)"
    )
    await browser.do("click", page=page, selector=".recording .button")
    await browser.wait_for(page, "document.querySelector('.recording-files a[download$=\".bag\"]') !== null")
    # Slowly, so that the playback does not end first.
    play = "rostether.gateway.playRecording(rostether.recordings.value.files[0].name, 0, 0.1, true)"
    await browser.do("evaluate", page=page, script=play)
    await browser.wait_for(page, "document.querySelector('.recording-playback') !== null")
    await browser.do("evaluate", page=page, script="void rostether.subscribe('/playback/ultrasound')")
    await browser.wait_for(page, "rostether.feed('/playback/ultrasound').last !== undefined")
    await browser.do("click", page=page, selector=".recording-playback [aria-label='Stop playing']")
    await browser.wait_for(page, "document.querySelector('.recording-playback') === null")
    # The page shows what the robot refuses.
    script = "rostether.gateway.playRecording('none.bag', 0, 1, true)"
    await browser.do("evaluate", page=page, script=script)
    await browser.wait_for(page, "document.querySelector('.banner')?.innerText.includes('none.bag')")


async def test_a_view_only_page_cannot_act(robot: Robot, browser: Browser) -> None:
    await robot.kill_dashboard()
    await robot.start_dashboard("--token", "all", "--view-token", "look")
    page = await browser.do("open", url=robot.url + "#token=look")
    await browser.do("evaluate", page=page, script="void (location.hash = '#/controls')")
    await browser.wait_for(page, "document.querySelector('.push')?.matches(':disabled')")
    await browser.do("evaluate", page=page, script="void rostether.subscribe('/ultrasound')")
    await browser.wait_for(page, "rostether.feed('/ultrasound').last !== undefined")
    # It sends nothing that it may not, neither while the controls are shown nor afterwards.
    await browser.do("evaluate", page=page, script="void (location.hash = '#/console')")
    await browser.wait_for(page, "document.querySelector('.push') === null")
    await browser.do("evaluate", page=page, script="void rostether.subscribe('/diagnostics')")
    await browser.wait_for(page, "rostether.feed('/diagnostics').last !== undefined")
    banner = "document.querySelector('.banner')?.innerText"
    assert await browser.do("evaluate", page=page, script=banner) is None
    await browser.do("evaluate", page=page, script="void (location.hash = '#/services')")
    await browser.wait_for(
        page, "document.querySelector('.services .empty h2')?.innerText.includes('only view')"
    )
    async with rostether.join("driven", master=robot.master) as graph:
        await graph.subscriber("/cmd_vel", "geometry_msgs/Twist", lambda _: None)
        await browser.do("evaluate", page=page, script="void (location.hash = '#/drive')")
        state = "document.querySelector('.drive-state')?.innerText"
        await browser.wait_for(page, f"{state} === 'View only: this page cannot drive'")

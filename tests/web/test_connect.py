"""A board on a serial port of the device that shows the page, the page's relay, the server and the bridge."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

import rostether
from interop.ros1_peers import free_port
from web.browser import Browser
from web.robot import POLL_S, TIMEOUT_S, end, run_rostether, wait_for_page
from web.usb_board import UsbBoard

pytestmark = pytest.mark.asyncio(loop_scope="session")

STATE = "document.querySelector('.connect-board .badge')?.innerText"


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def served(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[tuple[str, str]]:
    """The page and the master of a bridge that only serves boards of pages."""
    port, master = free_port(), f"http://127.0.0.1:{free_port()}"
    process = await run_rostether(
        *(tmp_path_factory.mktemp("home"), master),
        *("serve", "web:", "--ros1", "--dashboard", f"127.0.0.1:{port}"),
    )
    url = f"http://127.0.0.1:{port}/"
    try:
        await wait_for_page(url, process)
        yield url, master
    finally:
        await end(process, signal.SIGTERM)


async def connect_board(url: str, board: UsbBoard, browser: Browser) -> int:
    """Open the page, choose the port, and connect the board as uno."""
    page = await browser.do("open", url=url + "#/connect", script=board.script)
    await browser.do("click", page=page, selector=".connect-ports .primary")
    await browser.do("fill", page=page, selector=".connect-form input", text="uno")
    await browser.do("click", page=page, selector=".connect-form .primary")
    await browser.wait_for(page, f"{STATE} === 'Connected'")
    return int(page)


async def test_the_board_of_a_page_is_a_node(served: tuple[str, str], browser: Browser) -> None:
    url, master = served
    async with UsbBoard() as board, rostether.join("probe", master=master) as graph:
        received: list[str] = []

        async def follow() -> None:
            async for message in graph.messages("/heard", "std_msgs/String"):
                received.append(message.data)

        async def publish_until_received(text: str) -> None:
            async with asyncio.timeout(TIMEOUT_S):
                while text not in received:
                    publisher.publish(data=text)
                    await asyncio.sleep(POLL_S)

        following = asyncio.ensure_future(follow())
        publisher = await graph.publisher("/spoken", "std_msgs/String")
        page = await connect_board(url, board, browser)
        await publish_until_received("by page")
        assert board.bauds == ["57600"]
        # The board was reset once, before the robot got its bytes.
        assert board.signals == [False, True]

        await browser.do("hide", page=page, hidden=True)
        await browser.wait_for(page, f"{STATE} === 'Disconnected while the page is hidden'")
        await browser.do("hide", page=page, hidden=False)
        await browser.wait_for(page, f"{STATE} === 'Connected'")
        await publish_until_received("again")

        await board.unplug()
        await browser.wait_for(page, f"{STATE} === 'Unplugged'")
        await browser.do(
            "evaluate", page=page, script="void navigator.serial.dispatchEvent(new Event('connect'))"
        )
        await browser.wait_for(page, f"{STATE} === 'Connected'")
        await publish_until_received("plugged in")
        # It keeps its name after every reconnection.
        await browser.do("evaluate", page=page, script="void (location.hash = '#/boards')")
        await browser.wait_for(page, "document.body.innerText.includes('web_uno')")
        assert not await browser.do(
            "evaluate", page=page, script="document.body.innerText.includes('web_uno_2')"
        )
        assert (await browser.do("seen", page=page))["errors"] == []
        following.cancel()


async def test_a_browser_without_serial_ports_shows_a_message(
    served: tuple[str, str], browser: Browser
) -> None:
    script = "delete Navigator.prototype.serial"
    page = await browser.do("open", url=served[0] + "#/connect", script=script)
    await browser.wait_for(page, "document.body.innerText.includes('This browser cannot use serial ports')")

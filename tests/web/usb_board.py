"""A board on a serial port of the browser: a Python device behind a WebSocket for `fake_serial.js`."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any, Self

from websockets.asyncio.server import Server, ServerConnection, serve

from rostether.device.device import Device
from rostether.mechanisms.tasks import start_task
from rostether.transports.memory import memory_pair

SCRIPT = Path(__file__).parent / "fake_serial.js"


class UsbBoard:
    """Publishes the messages of /spoken on /heard; `signals` are the changes of its DTR line."""

    def __init__(self) -> None:
        self.signals: list[bool] = []
        self.bauds: list[str] = []
        self._server: Server | None = None
        self._device_end, self._port = memory_pair()
        self._device = Device(self._device_end)
        self._browser: ServerConnection | None = None
        self._sending: set[asyncio.Task[None]] = set()

    @property
    def script(self) -> str:
        """The script that gives a page the serial port."""
        assert self._server is not None
        port = next(iter(self._server.sockets)).getsockname()[1]
        return f"globalThis.boardUrl = 'ws://127.0.0.1:{port}';\n{SCRIPT.read_text(encoding='utf-8')}"

    async def __aenter__(self) -> Self:
        self._server = await serve(self._relay, "127.0.0.1", 0, compression=None)
        received = self._device.publisher("heard", "std_msgs/String")

        def answer(message: Any) -> None:
            received.publish(data=message.data)

        self._device.subscriber("spoken", "std_msgs/String", answer)
        await self._device.__aenter__()
        self._port.start(self)
        return self

    async def __aexit__(self, *error: Any) -> None:
        await self._device.__aexit__(*error)
        assert self._server is not None
        self._server.close()
        await self._server.wait_closed()

    def data_received(self, data: bytes) -> None:
        """Forward bytes of the board; without an open port they are lost."""
        if self._browser is not None:
            start_task(self._sending, self._browser.send(data))

    def connection_lost(self, _: object) -> None:
        """The test ends."""

    def pause_writing(self) -> None:
        """Do nothing: the test sends little."""

    def resume_writing(self) -> None:
        """Do nothing: the test sends little."""

    async def unplug(self) -> None:
        """Make the open port fail."""
        assert self._browser is not None
        await self._browser.close()

    async def _relay(self, browser: ServerConnection) -> None:
        assert browser.request is not None
        self.bauds.append(browser.request.path.partition("baud=")[2])
        self._browser = browser
        async for message in browser:
            if isinstance(message, str):
                self.signals.append(json.loads(message)["dataTerminalReady"])
            else:
                self._port.write(message)
        if self._browser is browser:
            self._browser = None

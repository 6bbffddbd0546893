"""A board behind a simulated radio: it publishes a counter and has an LED."""

from __future__ import annotations

import asyncio
from typing import Any, Self

from rostether.device.device import Device
from rostether.mechanisms.tasks import cancel_all
from rostether.rosserial.device_link import DeviceLinkConfig
from rostether.serde.store import TypeStore
from rostether.transports.transport import Transport

# The buffers of the established library on an Uno.
_UNO = DeviceLinkConfig(
    max_subscribers=25, max_publishers=25, input_buffer_bytes=280, output_buffer_bytes=280
)


class CountingBoard(Device):
    """Publishes a counter on `NAME/count` (std_msgs/UInt32); `NAME/led` (std_msgs/Bool) switches its LED.

    `published` and `led_changes` are counts since the start.
    """

    def __init__(
        self, name: str, transport: Transport, *, rate_hz: float, store: TypeStore | None = None
    ) -> None:
        super().__init__(transport, config=_UNO, store=store)
        self.name = name
        self.published = 0
        self.led_changes = 0
        self.is_lit = False
        self._period_s = 1 / rate_hz
        self._count = self.publisher(f"{name}/count", "std_msgs/UInt32")
        self.subscriber(f"{name}/led", "std_msgs/Bool", self._switch)
        self._counting: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        """Start counting."""
        await super().__aenter__()
        self._counting = asyncio.get_running_loop().create_task(self._run())
        return self

    async def close(self) -> None:
        """Stop counting, and close the device."""
        if self._counting is not None:
            await cancel_all(self._counting)
        await super().close()

    async def _run(self) -> None:
        while True:
            await asyncio.sleep(self._period_s)
            if self._count.publish(data=self.published + 1):
                self.published += 1

    def _switch(self, message: Any) -> None:
        self.led_changes += message.data != self.is_lit
        self.is_lit = message.data

"""A GPIO line as a source of numbers, with the package `gpiod` (extra `gpio`)."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from typing import Any

from msgspec import Struct

from rostether.errors import SensorError
from rostether.extras import imported_from
from rostether.mechanisms.tasks import occurs_within

# The interval for a line that does not change.
REPEAT_S = 1.0

BIASES = ("as_is", "disabled", "pull_up", "pull_down")


class GpioLine(Struct, frozen=True):
    """A line of a chip: its number, or its name, such as GPIO17."""

    line: str
    chip: str = "/dev/gpiochip0"
    bias: str = "as_is"
    is_active_low: bool = False

    async def levels(self) -> AsyncGenerator[float, None]:
        """Yield 1.0 (active) or 0.0 now, at each change, and every second.

        Raises OSError, SensorError, and ConfigError if gpiod is not installed.
        """
        gpiod = gpio_package()
        changed = asyncio.Event()
        loop = asyncio.get_running_loop()
        request = self._request(gpiod)
        try:
            loop.add_reader(request.fd, changed.set)
            try:
                while True:
                    changed.clear()
                    while request.wait_edge_events(0):
                        request.read_edge_events()
                    values = request.get_values()
                    yield float(values[0] == gpiod.line.Value.ACTIVE)
                    await occurs_within(changed, REPEAT_S)
            finally:
                loop.remove_reader(request.fd)
        finally:
            request.release()

    def _request(self, gpiod: Any) -> Any:
        settings = gpiod.LineSettings(
            direction=gpiod.line.Direction.INPUT,
            edge_detection=gpiod.line.Edge.BOTH,
            bias=getattr(gpiod.line.Bias, self.bias.upper()),
            active_low=self.is_active_low,
        )
        key: int | str = int(self.line) if self.line.isdecimal() else self.line
        try:
            return gpiod.request_lines(self.chip, config={key: settings}, consumer="rostether")
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise SensorError(f"{self.chip}: line {self.line} cannot be read: {reason}") from None


def gpio_package() -> Any:
    """Return the package `gpiod`. Raises ConfigError if it is not installed."""
    with imported_from("gpio", "GPIO lines need another package"):
        import gpiod
    return gpiod

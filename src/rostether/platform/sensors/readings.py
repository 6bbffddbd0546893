"""Publishes the readings of a source: reopens it after a failure, and reports the sensor's state."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing
from typing import TypeVar

from rostether.errors import ConfigError, RostetherError
from rostether.graph.ports import Level
from rostether.mechanisms.rate_limits import RepeatLimiter
from rostether.platform.sensor_state import SILENT_S
from rostether.platform.sensors.registered_sensor import RegisteredSensor

T = TypeVar("T")

# The interval between attempts; a device is plugged in by hand.
RETRY_S = 1.0


class Pace:
    """Makes a loop run `rate_hz` times a second; a late loop does not catch up."""

    def __init__(self, rate_hz: float) -> None:
        self._period_s = 1 / rate_hz
        self._next_s = 0.0

    async def wait(self) -> None:
        """Wait for the next turn."""
        now_s = asyncio.get_running_loop().time()
        self._next_s = max(self._next_s + self._period_s, now_s)
        await asyncio.sleep(self._next_s - now_s)


async def paced(read: Callable[[], T], rate_hz: float) -> AsyncGenerator[T, None]:
    """Yield what `read` returns, `rate_hz` times a second; it runs in a thread, because it may block."""
    pace = Pace(rate_hz)
    while True:
        yield await asyncio.to_thread(read)
        await pace.wait()


def reason_of(error: Exception) -> str:
    """Return the message of an error, with the name of the file."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)


async def publish_readings(
    sensor: RegisteredSensor,
    open_source: Callable[[], AsyncGenerator[T, None]],
    publish: Callable[[T], None],
    *,
    hint: str,
    silence: str = "",
) -> None:
    """Publish each reading until canceled; `publish` also sets the state. Raises the source's ConfigError.

    If `open_source` raises OSError or RostetherError, the device is opened again each second; `hint` is the
    advice for the user, which follows the error. `silence` is the reason to show while no reading arrives.
    """
    loop, report = asyncio.get_running_loop(), sensor.report
    period_s = 1 / sensor.description.rate_hz if sensor.description.rate_hz else 0.0
    silence_s = max(SILENT_S, 3 * period_s)
    failure = ""
    limiter = RepeatLimiter()
    is_first = True

    def report_silence() -> None:
        if is_first and silence:
            report(Level.WARN, f"{sensor.description.id}: {silence}")
        # A sensor without any reading yet has not become silent.
        sensor.set_state("init" if is_first else "sleeping", silence)

    while True:
        silent = loop.call_later(silence_s, report_silence)
        try:
            # A generator that is not closed would keep its device open.
            async with aclosing(open_source()) as readings:
                async for reading in readings:
                    if failure:
                        report(Level.INFO, f"{sensor.description.id} works again")
                        failure = ""
                    is_first = False
                    publish(reading)
                    silent.cancel()
                    silent = loop.call_later(silence_s, report_silence)
        except ConfigError:
            # A retry would not help.
            raise
        except (OSError, RostetherError) as error:
            reason = reason_of(error)
        else:
            reason = "the source has ended"
        finally:
            silent.cancel()
        sensor.set_state("alert", reason)
        # Without a limit, one damaged picture in a folder would be reported each time.
        if reason != failure and limiter.admit(reason, loop.time()) is not None:
            failure = reason
            sensor.report(
                Level.ERROR, f"{sensor.description.id}: {reason}; {hint}; trying again every second"
            )
        await asyncio.sleep(RETRY_S)

"""joy_node: publishes a joystick's state as sensor_msgs/Joy, even after it was unplugged for a while."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct
from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.nodes.joystick import EVENT, Joystick, PublishTiming

DEFAULT_DEVICE = "/dev/input/js0"

# The interval between attempts; a joystick is plugged in by hand.
_RETRY_S = 1.0
_READ_BYTES = EVENT.size * 64

# 10 kHz is more than any device sends.
_MIN_COALESCE_S = 1e-4


class JoySettings(Struct, frozen=True):
    """The parameters of joy_node; `autorepeat_rate_hz` 0 publishes only when something has changed."""

    device: str = DEFAULT_DEVICE
    deadzone: float = 0.05
    autorepeat_rate_hz: float = 0.0
    coalesce_interval_s: float = 0.001
    sticky_buttons: bool = False
    default_trig_val: bool = False

    def checked(self) -> JoySettings:
        """Return the settings, limited to valid ranges.

        Raises ConfigError for a rate or an interval below 0.
        """
        if self.autorepeat_rate_hz < 0 or self.coalesce_interval_s < 0:
            raise ConfigError("autorepeat_rate and coalesce_interval must not be below 0")
        return replace(self, coalesce_interval_s=max(self.coalesce_interval_s, _MIN_COALESCE_S))


async def publish_joystick(
    graph: TypedGraph, settings: JoySettings, report: Callable[[Level, str], None]
) -> None:
    """Publish `joy` until canceled. Raises ConfigError, GraphError."""
    settings = settings.checked()
    publisher = await graph.publisher("joy", "sensor_msgs/Joy")
    is_reported = False
    while True:
        try:
            descriptor = os.open(settings.device, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            if not is_reported:
                report(
                    Level.ERROR,
                    f"no joystick at {settings.device}: {error.strerror}; trying again every second",
                )
                is_reported = True
            await asyncio.sleep(_RETRY_S)
            continue
        report(Level.INFO, f"Opened joystick: {settings.device}")
        try:
            await _OpenJoystick(graph, publisher, settings, descriptor).run()
        finally:
            os.close(descriptor)
        report(Level.ERROR, f"the joystick at {settings.device} was disconnected; waiting for it")
        is_reported = True
        await asyncio.sleep(_RETRY_S)


class _OpenJoystick:
    """One opened device, from opening to disconnection."""

    def __init__(
        self, graph: TypedGraph, publisher: TypedPublisher[...], settings: JoySettings, descriptor: int
    ) -> None:
        self._graph = graph
        self._publisher = publisher
        self._settings = settings
        self._descriptor = descriptor
        self._joystick = Joystick(settings.deadzone, settings.sticky_buttons, settings.default_trig_val)
        self._ended = asyncio.Event()
        self._timer: asyncio.TimerHandle | None = None
        self._is_gathering = False
        self._sequence = 0

    async def run(self) -> None:
        loop = asyncio.get_running_loop()
        loop.add_reader(self._descriptor, self._read)
        try:
            self._repeat_later()
            await self._ended.wait()
            if self._sequence:
                # The last position would stay in effect for programs that wait for a change.
                self._joystick.release()
                self._publish()
        finally:
            loop.remove_reader(self._descriptor)
            if self._timer is not None:
                self._timer.cancel()

    def _read(self) -> None:
        try:
            data = os.read(self._descriptor, _READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._ended.set()
            return
        timing = self._joystick.feed(data)
        if timing is PublishTiming.NOW:
            self._publish()
        elif timing is PublishTiming.SOON and not self._is_gathering:
            self._is_gathering = True
            self._start_timer(self._settings.coalesce_interval_s)

    def _publish(self) -> None:
        self._sequence += 1
        self._publisher.publish(
            header={
                "seq": self._sequence,
                "stamp": self._graph.now(),
                "frame_id": self._settings.device,
            },
            axes=self._joystick.axes,
            buttons=self._joystick.buttons,
        )
        self._is_gathering = False
        self._repeat_later()

    def _repeat_later(self) -> None:
        if self._settings.autorepeat_rate_hz > 0:
            self._start_timer(1 / self._settings.autorepeat_rate_hz)
        elif self._timer is not None:
            self._timer.cancel()

    def _start_timer(self, delay_s: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(delay_s, self._publish)


def device_named(name: str, folder: Path = Path("/dev/input")) -> str | None:
    """Return the joystick with this name, or None."""
    import fcntl

    # JSIOCGNAME of linux/joystick.h, for a name of 128 bytes.
    get_name = 0x80006A13 | 128 << 16
    for device in sorted(folder.glob("js*")):
        try:
            descriptor = os.open(device, os.O_RDONLY | os.O_NONBLOCK)
        except OSError:
            continue
        try:
            answer = fcntl.ioctl(descriptor, get_name, bytes(128))
        except OSError:
            continue
        finally:
            os.close(descriptor)
        if answer.split(b"\0", 1)[0].decode(errors="replace") == name:
            return str(device)
    return None

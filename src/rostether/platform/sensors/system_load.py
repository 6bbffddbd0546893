"""The node system_load: one sensor each for CPU, memory, temperature and disk of a robot's computer."""

from __future__ import annotations

import asyncio
import shutil
from functools import partial
from pathlib import Path

from msgspec import Struct

from rostether.errors import SensorError
from rostether.graph.ports import Report
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensor_registration import SensorDescription
from rostether.platform.sensors.number_file import read_number
from rostether.platform.sensors.readings import paced
from rostether.platform.sensors.value import MESSAGE_TYPE, Scaling, publish_values

_CELSIUS = "\N{DEGREE SIGN}C"

# A Raspberry Pi slows down at 80 °C, and a full disk stops logs and recordings.
_ALERT_ABOVE = {"memory": 95.0, "temperature": 80.0, "disk": 95.0}


class SystemFiles(Struct, frozen=True):
    """The files where Linux reports its load, and a folder on the disk to watch."""

    proc: Path = Path("/proc")
    thermal: Path = Path("/sys/class/thermal")
    disk: Path = Path("/")


class SystemLoad:
    """Reads the load; each value is in percent, except the temperature. Raises OSError, SensorError."""

    def __init__(self, files: SystemFiles) -> None:
        self._files = files
        self._before: tuple[int, int] | None = None

    def cpu(self) -> float:
        """Return the CPU load since the last call; the first call returns the load since boot."""
        first = (self._files.proc / "stat").read_text().split("\n", 1)[0].split()
        if first[:1] != ["cpu"]:
            raise SensorError(f"{self._files.proc / 'stat'} does not start with cpu")
        # user, nice, system, idle, iowait, irq, softirq, steal; guest time is in user time.
        times = [int(each) for each in first[1:9]]
        busy, total = sum(times) - sum(times[3:5]), sum(times)
        before_busy, before_total = self._before or (0, 0)
        self._before = busy, total
        return 100 * (busy - before_busy) / max(1, total - before_total)

    def memory(self) -> float:
        """Return the share of memory in use."""
        values = {}
        for line in (self._files.proc / "meminfo").read_text().splitlines():
            name, _, rest = line.partition(":")
            values[name] = rest.split()[0] if rest.split() else "0"
        try:
            return 100 * (1 - int(values["MemAvailable"]) / int(values["MemTotal"]))
        except (KeyError, ValueError, ZeroDivisionError):
            raise SensorError(f"{self._files.proc / 'meminfo'} lacks MemTotal or MemAvailable") from None

    def temperature(self) -> float:
        """Return the temperature of the hottest zone in degrees Celsius."""
        zones = [zone / "temp" for zone in self._files.thermal.glob("thermal_zone*")]
        if not zones:
            raise SensorError(f"{self._files.thermal} has no thermal zone")
        return max(read_number(each) for each in zones) / 1000

    def disk(self) -> float:
        """Return the share of disk space in use."""
        usage = shutil.disk_usage(self._files.disk)
        return 100 * usage.used / max(1, usage.used + usage.free)


async def publish_system_load(
    graph: TypedGraph,
    platform: str,
    word: str,
    rate_hz: float,
    files: SystemFiles,
    report: Report,
) -> None:
    """Publish CPU, memory and disk, and the temperature if it is measured, until canceled.

    `word` is the robot's name in the ids of the sensors. Raises GraphError.
    """
    load = SystemLoad(files)
    readers = {"cpu": load.cpu, "memory": load.memory, "disk": load.disk}
    # Virtual machines have no temperature sensor.
    if any(files.thermal.glob("thermal_zone*")):
        readers["temperature"] = load.temperature
    try:
        async with asyncio.TaskGroup() as group:
            for name, read in readers.items():
                unit = _CELSIUS if name == "temperature" else "%"
                what = SensorDescription(
                    f"{word}/{name}", platform, "ANALOG", MESSAGE_TYPE, name, unit, rate_hz=rate_hz
                )
                scaling = Scaling(alert_above=_ALERT_ABOVE.get(name, float("inf")))
                readings = partial(paced, read, rate_hz)
                group.create_task(
                    publish_values(
                        graph, what, readings, scaling, report, hint="this machine may not report it"
                    )
                )
    except ExceptionGroup as failures:
        raise failures.exceptions[0] from None

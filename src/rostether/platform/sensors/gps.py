"""The node gps: the positions of a receiver that sends NMEA over a serial port or TCP."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator

from rostether.errors import SensorError, TransportError
from rostether.graph.ports import Level, Report
from rostether.graph.typed_graph import TypedGraph
from rostether.platform.sensor_registration import SensorDescription
from rostether.platform.sensors.nmea import NmeaReader, Position
from rostether.platform.sensors.readings import publish_readings
from rostether.platform.sensors.registered_sensor import registered_sensor
from rostether.transports.address import Address
from rostether.transports.opening import open_transport
from rostether.transports.transport import SmallWriter

MESSAGE_TYPE = "sensor_msgs/NavSatFix"

# Receivers send at most ten positions per second; a slow subscriber gets the newest ones.
_MAX_WAITING = 100

# After this time without a position, the sensor reports the reason, before it counts as silent.
_REPORT_S = 2.5


async def publish_positions(
    graph: TypedGraph, description: SensorDescription, address: Address, report: Report
) -> None:
    """Publish the positions of a receiver as a sensor until canceled. Raises GraphError, ConfigError."""
    # A missing package is reported immediately.
    NmeaReader()
    async with registered_sensor(graph, description, report) as sensor:
        reported = ""

        def publish(position: Position | str) -> None:
            nonlocal reported
            if isinstance(position, str):
                sensor.set_state("alert", position)
                if position != reported:
                    reported = position
                    report(Level.WARN, f"{description.id}: no position from {address}: {position}")
                return
            reported = ""
            sensor.publish(header=sensor.header(), **position.fields)
            if position.has_fix:
                sensor.set_state("ready")
            else:
                sensor.set_state("sleeping", f"no position yet; satellites: {position.satellites}")

        await publish_readings(
            sensor,
            lambda: positions(address, max(_REPORT_S, _REPORT_S / description.rate_hz)),
            publish,
            hint="plug the receiver in, or choose another ~port",
        )


async def positions(address: Address, report_s: float) -> AsyncGenerator[Position | str, None]:
    """Yield the positions that arrive, and after each `report_s` without one the reason.

    Raises TransportError, SensorError, ConfigError.
    """
    transport = await open_transport(address)
    receiver = _Receiver(f"{address}")
    transport.start(receiver)
    try:
        while True:
            try:
                async with asyncio.timeout(report_s):
                    position = await receiver.next_position()
            except TimeoutError:
                yield receiver.reader.read_and_clear_problem()
            else:
                yield position
    finally:
        transport.close()
        await transport.wait_closed()


class _Receiver(SmallWriter):
    def __init__(self, where: str) -> None:
        self._where = where
        self.reader = NmeaReader()
        self._waiting: asyncio.Queue[Position | None] = asyncio.Queue(_MAX_WAITING)

    async def next_position(self) -> Position:
        position = await self._waiting.get()
        if position is None:
            raise SensorError(f"{self._where} closed the connection")
        return position

    def data_received(self, data: bytes) -> None:
        for position in self.reader.feed(data):
            self._put(position)

    def connection_lost(self, error: TransportError | None) -> None:
        self._put(None)

    def _put(self, position: Position | None) -> None:
        if self._waiting.full():
            self._waiting.get_nowait()
        self._waiting.put_nowait(position)

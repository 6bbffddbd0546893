from __future__ import annotations

import asyncio
import contextlib
import math
import os
import sys
from collections.abc import AsyncGenerator
from functools import reduce
from operator import xor
from typing import Any

import pytest

from rostether.errors import ConfigError, SensorError
from rostether.platform.sensors.gps import MESSAGE_TYPE, positions, publish_positions
from rostether.platform.sensors.nmea import NmeaReader, Position
from rostether.transports.address_parser import parse_address
from rostether.transports.sockets import close_servers
from unit.platform.datagrams import running
from unit.platform.sensors.shown_sensors import described, shown_sensors
from waiting import until

pytest.importorskip("pynmea2")

FIX = b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"
NO_FIX = b"$GPGGA,123520,,,,,0,03,,,M,,M,,*62\r\n"
OTHER = b"$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n"
WHAT = described("GPS", MESSAGE_TYPE, rate_hz=1.0)


@pytest.mark.parametrize("step", [1, 7, 1000])
def test_sentences_are_read_in_any_pieces(step: int) -> None:
    reader = NmeaReader()
    data = b"\xb5\x62\x01" + FIX + OTHER + FIX.replace(b"4807", b"4808") + NO_FIX
    found = [each for start in range(0, len(data), step) for each in reader.feed(data[start : start + step])]
    assert len(found) == 2
    fix = found[0]
    assert (fix.status, fix.satellites, fix.hdop) == (0, 8, 0.9)
    assert math.isclose(fix.latitude, 48 + 7.038 / 60)
    assert math.isclose(fix.longitude, 11 + 31 / 60)
    # The height above the ellipsoid.
    assert math.isclose(fix.altitude_m, 592.3)
    assert not found[1].has_fix
    assert found[1].satellites == 3
    assert reader.damaged_count == 1


def test_why_there_is_no_position() -> None:
    reader = NmeaReader()
    assert "sends nothing" in reader.read_and_clear_problem()
    reader.feed(bytes(range(128, 256)) * 4)
    assert "no NMEA sentences; check the baud rate" in reader.read_and_clear_problem()
    reader.feed(OTHER * 2 + FIX[:20] + b"\n")
    assert "none with a position (GGA)" in reader.read_and_clear_problem()
    assert not reader.feed(FIX.replace(b"4807", b"4808"))
    assert "are damaged" in reader.read_and_clear_problem()
    assert "sends nothing" in reader.read_and_clear_problem()


@pytest.mark.parametrize(
    "sentence",
    [
        b"$GPGGA,123519,9107.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*",
        b"$GPGGA,123519,4807.038,N,99931.000,E,1,08,0.9,545.4,M,46.9,M,,*",
        b"$GPGGA,123519,4807.038,n,01131.000,e,1,08,0.9,545.4,M,46.9,M,,*",
    ],
)
def test_a_position_that_is_not_on_earth(sentence: bytes) -> None:
    reader = NmeaReader()
    checksum = reduce(xor, sentence[1:-1])
    assert not reader.feed(sentence + b"%02X\r\n" % checksum)
    assert reader.damaged_count == 1


def test_a_position_as_a_message() -> None:
    fields = Position(0, 8, 48.0, 11.0, 500.0, 2.0).fields
    assert fields["position_covariance"] == [100.0, 0, 0, 0, 100.0, 0, 0, 0, 400.0]
    assert fields["position_covariance_type"] == 1
    assert Position(-1, 3).fields["position_covariance_type"] == 0


@contextlib.asynccontextmanager
async def tcp_receiver() -> AsyncGenerator[tuple[str, list[asyncio.StreamWriter]], None]:
    writers: list[asyncio.StreamWriter] = []
    server = await asyncio.start_server(lambda _, writer: writers.append(writer), "127.0.0.1", 0)
    try:
        yield f"tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}?connect=yes", writers
    finally:
        await close_servers([server])
        for writer in writers:
            writer.close()


async def test_a_receiver_on_tcp_that_ends_and_comes_back() -> None:
    received: list[Any] = []
    async with shown_sensors() as shown, tcp_receiver() as (address, writers):
        await shown.viewer.subscriber(WHAT.topic, MESSAGE_TYPE, received.append)
        async with running(publish_positions(shown.robot, WHAT, parse_address(address), shown.report)):
            await until(lambda: writers)
            writers[0].write(NO_FIX)
            await shown.has_state(WHAT.id, "sleeping no position yet; satellites: 3")
            writers[0].write(FIX)
            await shown.has_state(WHAT.id, "ready")
            writers[0].close()
            await until(lambda: len(writers) == 2)
            writers[1].write(FIX)
            await until(lambda: len(received) == 3)
    assert [each.status.status for each in received] == [-1, 0, 0]
    assert math.isnan(received[0].latitude)
    assert received[1].latitude == pytest.approx(48.1173)
    assert any(" closed the connection" in each for each in shown.report.texts)


async def test_a_receiver_that_sends_no_position() -> None:
    async with tcp_receiver() as (address, writers):
        found = positions(parse_address(address), 0.05)
        assert "sends nothing" in str(await anext(found))
        writers[0].write(bytes(range(256)))
        async with asyncio.timeout(60):
            while "check the baud rate" not in str(await anext(found)):
                pass
        await found.aclose()


async def test_a_receiver_on_a_serial_port() -> None:
    master, slave = os.openpty()
    try:
        found = positions(parse_address(f"serial:{os.ttyname(slave)}?baud=9600"), 60.0)
        first = asyncio.ensure_future(anext(found))
        while not first.done():
            os.write(master, FIX)
            await asyncio.wait([first], timeout=0.05)
        position = first.result()
        assert isinstance(position, Position)
        assert position.satellites == 8
        await found.aclose()
    finally:
        os.close(master)
        os.close(slave)


def test_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pynmea2", None)
    with pytest.raises(ConfigError, match=r"GPS needs another package; run: .*rostether\[gps\]"):
        NmeaReader()


async def test_a_port_that_is_missing() -> None:
    with pytest.raises((OSError, SensorError, Exception), match="/dev/ttyNONE"):
        await anext(positions(parse_address("/dev/ttyNONE"), 60.0))

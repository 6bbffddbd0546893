"""The files that the page's plots save, read by rostether and, for ROS 2, by rosbags."""

from __future__ import annotations

import contextlib
import struct
import time
from pathlib import Path
from typing import Any

import pytest
from mcap.records import Chunk, MessageIndex
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from rostether.cli.dashboard.view import read_view
from rostether.msgdef.registry import Registry
from rostether.recording.checking import check
from rostether.recording.files import open_recording
from rostether.serde.store import TypeStore
from web.browser import TIMEOUT_S, Browser
from web.robot import Robot

pytestmark = pytest.mark.asyncio(loop_scope="session")


async def test_a_saved_plot_is_a_recording(robot: Robot, browser: Browser, tmp_path: Path) -> None:
    page = await browser.do(
        "open", url=robot.url + "#" + read_view("plots", ["/ultrasound/range"]).fragment("")
    )
    # Only the plot receives the topic.
    await browser.wait_for(page, "rostether.feed('/ultrasound').rate.hertz(performance.now()) > 0")
    await _check(page, browser, tmp_path / "plot.mcap")
    # As on a graph of only ROS 2.
    metadata = "{ ...rostether.info.value.metadata, recording_format: 'mcap' }"
    script = f"void (rostether.info.value = {{ ...rostether.info.value, metadata: {metadata} }})"
    await browser.do("evaluate", page=page, script=script)
    file = tmp_path / "ros2.mcap"
    await _check(page, browser, file)
    with AnyReader([file], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        read: list[Any] = [reader.deserialize(raw, each.msgtype) for each, _, raw in reader.messages()]
    assert all(0.02 < message.data < 5 for message in read)


async def _check(page: int, browser: Browser, file: Path) -> None:
    await browser.do(
        "download", page=page, selector="[aria-label='Save the shown data as MCAP']", path=str(file)
    )
    assert check(file, Registry()).faults == ()
    _check_index(file)
    codec = TypeStore(Registry()).codec("std_msgs/Float64")
    with contextlib.closing(open_recording(file)) as reader:
        messages = list(reader.messages())
    assert {message.connection.topic for message in messages} == {"/ultrasound/range"}
    assert all(0.02 < codec.decode(message.payload).data < 5 for message in messages)
    times_s = [message.time_ns / 1e9 for message in messages]
    assert times_s == sorted(times_s)
    assert abs(time.time() - times_s[-1]) < TIMEOUT_S


def _check_index(file: Path) -> None:
    with file.open("rb") as stream:
        records = list(StreamReader(stream, emit_chunks=True).records)
    [chunk] = [each for each in records if isinstance(each, Chunk)]
    [index] = [each for each in records if isinstance(each, MessageIndex)]
    assert index.records
    for time_ns, start in index.records:
        op, channel, log_time_ns = struct.unpack_from("<B8xH4xQ", chunk.data, start)
        assert (op, channel, log_time_ns) == (5, 1, time_ns)

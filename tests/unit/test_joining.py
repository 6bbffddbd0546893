from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

import rostether
from interop.ros1_peers import free_port
from rostether.errors import (
    ConfigError,
    MasterUnreachableError,
    SerializationError,
    UnknownTypeError,
)
from rostether.msg.sensor_msgs import Range
from rostether.ros1.master.server import MasterServer
from waiting import until


@pytest_asyncio.fixture
async def master() -> AsyncIterator[MasterServer]:
    server = await MasterServer.start(port=0)
    yield server
    await server.close()


async def test_join_as_a_program_does(master: MasterServer) -> None:
    async with rostether.join("/talker", master=master.uri) as talker:
        publisher = await talker.publisher("/chatter", "std_msgs/String", latch=True)
        publisher.publish(data="hello")
        async with rostether.join(master=master.uri) as listener:
            assert listener.node_name.startswith("/rostether_")
            message = await listener.wait_for_message("/chatter", timeout_s=60)
            assert message.data == "hello"
        assert master.api.registrations.nodes.keys() == {"/talker"}
    assert not master.api.registrations.nodes


async def test_names_and_environment(master: MasterServer) -> None:
    environ = {"ROS_MASTER_URI": master.uri, "ROS_NAMESPACE": "/arm"}
    async with rostether.join("mover", environ=environ, remappings={"speed": "fast"}) as graph:
        assert graph.node_name == "/arm/mover"
        assert graph.resolve("speed") == "/arm/fast"
    async with rostether.join("mover", environ=environ, namespace="/leg") as graph:
        assert graph.node_name == "/leg/mover"


async def test_a_failure_inside_the_block_still_leaves(master: MasterServer) -> None:
    with pytest.raises(ZeroDivisionError):
        async with rostether.join("/talker", master=master.uri):
            raise ZeroDivisionError
    assert not master.api.registrations.nodes


async def test_no_master() -> None:
    with pytest.raises(MasterUnreachableError):
        async with rostether.join("/talker", master="http://127.0.0.1:9"):
            pass


@pytest.mark.usefixtures("cold_start")
def test_the_package_starts_without_what_is_not_asked_for() -> None:
    code = (
        "import sys, rostether; print(*sys.modules); "
        "rostether.join; import rostether.joining; rostether.join('/x')"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert not {"asyncio", "rostether.device", "rostether.joining"} & set(loaded.split())


def test_an_unknown_name() -> None:
    with pytest.raises(AttributeError, match="nope"):
        _ = rostether.nope


async def test_join_a_ros2_graph() -> None:
    pytest.importorskip("zenoh")
    router = {
        "ZENOH_CONFIG_OVERRIDE": f'mode="router"; listen/endpoints=["tcp/127.0.0.1:{free_port()}"]; '
        "connect/endpoints=[]"
    }
    endpoint = router["ZENOH_CONFIG_OVERRIDE"].partition("listen/endpoints=")[2].partition(";")[0]
    peer = {"ZENOH_CONFIG_OVERRIDE": f"connect/endpoints={endpoint}"}
    async with (
        rostether.join("talker", ros2="zenoh", environ=router) as talker,
        rostether.join(ros2="zenoh", namespace="/ns", environ=peer) as listener,
    ):
        assert talker.node_name == "/talker"
        assert listener.node_name.startswith("/ns/rostether_")
        publisher = await talker.publisher("/pose", "geometry_msgs/msg/PoseStamped", latch=True)
        publisher.publish({"header": {"stamp": {"sec": 5, "nanosec": 7}, "frame_id": "map"}})
        message = await listener.wait_for_message("/pose", timeout_s=60)
        assert (message.header.stamp.sec, message.header.frame_id) == (5, "map")
        assert (await listener.snapshot()).topics["/pose"].type == "geometry_msgs/msg/PoseStamped"


async def test_join_ros2_takes_nothing_of_ros1() -> None:
    with pytest.raises(ConfigError, match="work only with ROS 1"):
        async with rostether.join(ros2="zenoh", master="http://127.0.0.1:9"):
            pass


async def test_arrays_as_numpy_has_them(master: MasterServer) -> None:
    async with rostether.join("/lidar", master=master.uri, numpy=True) as graph:
        scans = await graph.publisher("/scan", "sensor_msgs/LaserScan", latch=True)
        scans.publish(ranges=[1.0, 3.0])
        message = await graph.wait_for_message("/scan", timeout_s=60)
        assert message.ranges.mean() == 2.0


async def test_types_as_classes(master: MasterServer) -> None:
    async with rostether.join("/talker", master=master.uri) as graph:
        ranges = await graph.publisher("/range", Range, latch=True)
        ranges.publish(range=1.5, radiation_type=Range.INFRARED, header={"stamp": "now"})
        ranges.publish(Range(range=1.5))
        # mypy checks this file: an ignore without an error would fail.
        with pytest.raises(SerializationError, match="rnge"):
            ranges.publish(rnge=3)  # type: ignore[call-overload]
        message = await graph.wait_for_message("/range", Range, timeout_s=60)
        assert message.range == 1.5
        async for each in graph.messages("/range", Range):
            assert each.range + 1 == 2.5
            break
        with pytest.raises(UnknownTypeError, match="not a type"):
            await graph.publisher("/x", dict)  # type: ignore[arg-type]


async def test_a_loop_over_a_topic_without_publisher_is_logged(
    master: MasterServer, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("rostether.graph.message_stream.SILENCE_WARNING_S", 0.0)
    async with rostether.join("/listener", master=master.uri) as graph:
        await graph.publisher("/ultrasound", "std_msgs/String")
        waiting = asyncio.create_task(anext(graph.messages("/ultrasond")))
        await until(lambda: "/ultrasond, which has no publisher; did you mean /ultrasound?" in caplog.text)
        waiting.cancel()


def test_a_shell_completes_the_names_that_are_imported_late() -> None:
    assert dir(rostether) == ["Device", "join", "sync"]

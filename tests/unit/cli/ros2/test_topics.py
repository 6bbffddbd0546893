from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.reader import make_reader

from rostether.cli.topic import meter
from rostether.msgdef.registry import Registry
from rostether.ros2.type_description import SERVICE, SERVICE_TYPE
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.serde.store import TypeStore
from unit.cli.command_shell import Shell
from unit.cli.ros2.zenoh_world import STORE, ZenohWorld

pytestmark = pytest.mark.slow

IMU_HASH = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"


def test_list(world: ZenohWorld, shell: Shell) -> None:
    assert shell.output("topic", "list").splitlines() == [
        "/cmd_vel",
        "/goal",
        "/imu",
        "/name",
        "/parameter_events",
        "/rosout",
    ]
    assert shell.output("topic", "list", "-c") == "6\n"
    assert "/_raw" in shell.output("topic", "list", "--include-hidden-topics").splitlines()
    assert "/imu [sensor_msgs/msg/Imu]" in shell.output("topic", "list", "-t").splitlines()
    assert shell.output("topic", "list", "-v") == (
        "Published topics:\n"
        " * /imu [sensor_msgs/msg/Imu] 1 publisher\n"
        " * /name [std_msgs/msg/String] 1 publisher\n"
        " * /parameter_events [rcl_interfaces/msg/ParameterEvent] 1 publisher\n"
        " * /rosout [rcl_interfaces/msg/Log] 1 publisher\n"
        "\n"
        "Subscribed topics:\n"
        " * /cmd_vel [geometry_msgs/msg/Twist] 1 subscriber\n"
        " * /goal [geometry_msgs/msg/Pose] 1 subscriber\n"
        "\n"
    )
    assert shell.output("topic", "list", "-s").splitlines() == ["/cmd_vel", "/goal"]
    records = {each["topic"]: each for each in shell("topic", "list", "--json").records}
    assert records["/imu"] == {
        "topic": "/imu",
        "type": "sensor_msgs/msg/Imu",
        "publishers": ["/far/board"],
        "subscribers": [],
    }


def test_a_wrong_domain_is_reported(world: ZenohWorld, shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    # A busy machine answers late.
    monkeypatch.setattr("rostether.ros2.zenoh.node.DOMAINS_TIMEOUT_S", 60.0)
    listed = shell("topic", "list")
    assert listed.out == ""
    assert "no nodes; there are nodes in domain 0; check ROS_DOMAIN_ID" in listed.err


def test_info(world: ZenohWorld, shell: Shell) -> None:
    assert shell.output("topic", "info", "imu") == (
        "Type: sensor_msgs/msg/Imu\nPublisher count: 1\nSubscription count: 0\n"
    )
    text = shell.output("topic", "info", "-v", "/name")
    assert re.sub(r"GID: [0-9a-f]{2}(\.[0-9a-f]{2}){15}\n", "GID: x\n", text) == (
        "Type: std_msgs/msg/String\n\n"
        "Publisher count: 1\n\n"
        "Node name: board\n"
        "Node namespace: /far\n"
        "Topic type: std_msgs/msg/String\n"
        "Topic type hash: RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18\n"
        "Endpoint type: PUBLISHER\n"
        "GID: x\n"
        "QoS profile:\n"
        "  Reliability: RELIABLE\n"
        "  History (Depth): KEEP_LAST (1)\n"
        "  Durability: TRANSIENT_LOCAL\n"
        "  Lifespan: Infinite\n"
        "  Deadline: Infinite\n"
        "  Liveliness: AUTOMATIC\n"
        "  Liveliness lease duration: Infinite\n\n"
        "Subscription count: 0\n\n"
    )
    (record,) = shell("topic", "info", "--json", "/imu").records
    assert record["publishers"][0]["type_hash"] == IMU_HASH
    assert "topic /nope has no publisher and no subscriber" in shell.failure("topic", "info", "/nope")


def test_type_and_find(world: ZenohWorld, shell: Shell) -> None:
    assert shell.output("topic", "type", "/imu") == "sensor_msgs/msg/Imu\n"
    for spelling in ("std_msgs/msg/String", "std_msgs/String"):
        assert shell.output("topic", "find", spelling) == "/name\n"


def test_echo(world: ZenohWorld, shell: Shell) -> None:
    lines = shell.output("topic", "echo", "--once", "--no-arr", "/imu").splitlines()
    assert lines[:5] == ["header:", "  stamp:", "    sec: 5", "    nanosec: 7", "  frame_id: base"]
    assert "orientation_covariance: '<array type: double[9]>'" in lines
    assert lines[-1] == "---"
    # A latched message reaches a late subscriber.
    assert shell.output("topic", "echo", "--once", "/name", "std_msgs/msg/String") == "data: arm\n---\n"


def test_echo_of_fields(world: ZenohWorld, shell: Shell) -> None:
    once = ("topic", "echo", "--once")
    assert shell.output(*once, "--field", "header.stamp", "/imu") == "sec: 5\nnanosec: 7\n---\n"
    assert shell.output(*once, "/imu/header/frame_id") == "base\n---\n"
    assert shell.output(*once, "--field", "orientation_covariance[0]", "/imu") == "0.0\n---\n"
    assert shell.output(*once, "--csv", "/imu").startswith("5,7,base,0.0,")
    assert "has no field 'nope'; it has header, orientation, " in shell.failure(
        *once, "--field", "nope", "/imu"
    )
    (record,) = shell(*once, "--json", "--filter", "m.angular_velocity.z > 0", "/imu").records
    assert record["header"] == {"stamp": {"sec": 5, "nanosec": 7}, "frame_id": "base"}


def test_echo_shortens_long_values(world: ZenohWorld, shell: Shell) -> None:
    once = ("topic", "echo", "--once", "/_raw")
    assert shell.output(*once) == f"data: {'x' * 128}...\n---\n"
    assert shell.output(*once, "-l", "3") == "data: xxx...\n---\n"
    assert shell.output(*once, "--full-length") == f"data: {'x' * 200}\n---\n"
    assert shell.output(*once, "--no-str") == "data: '<string length: <200>>'\n---\n"


def test_ros2_options_are_accepted(world: ZenohWorld, shell: Shell) -> None:
    habits = ("--qos-profile", "sensor_data", "--qos-reliability", "best_effort", "--no-daemon")
    assert shell.output("topic", "echo", "--once", *habits, "/name") == "data: arm\n---\n"
    assert "/imu" in shell.output("topic", "list", "--no-daemon", "--spin-time", "1")


def test_echo_refuses_a_name_that_ros2_does_not_allow(world: ZenohWorld, shell: Shell) -> None:
    assert "'/sensors/1' is not a ROS 2 topic" in shell.failure("topic", "echo", "/sensors/1")


def test_echo_of_nothing_ends_in_time(world: ZenohWorld, shell: Shell) -> None:
    echo = ("topic", "echo", "--timeout")
    assert "no message arrived on /cmd_vel within 0.2 s; `rostether topic info" in shell.failure(
        *echo, "0.2", "/cmd_vel", "geometry_msgs/Twist"
    )
    for seconds in ("0.5", "5", "30"):
        result = shell(*echo, seconds, "/name", "std_msgs/String")
        if result.out:
            break
    assert (result.code, result.out, result.err) == (0, "data: arm\n---\n", "")
    few = shell.failure(*echo, seconds, "-n", "2", "/name", "std_msgs/String")
    assert f"only 1 of 2 messages arrived on /name within {seconds} s" in few


def test_pub(world: ZenohWorld, shell: Shell) -> None:
    out = shell.output("topic", "pub", "-1", "/cmd_vel", "geometry_msgs/msg/Twist", "{linear: {x: 2}}")
    # The command knows immediately, or shortly afterwards, for which nodes it waits.
    assert out.removeprefix("Waiting for at least 1 matching subscription(s)...\n") == (
        "publisher: beginning loop\n"
        "publishing #1: geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=2.0, y=0.0, z=0.0), "
        "angular=geometry_msgs.msg.Vector3(x=0.0, y=0.0, z=0.0))\n\n"
    )
    # The command's messages may still be in transit.
    world.wait_until(lambda: bool(world.received))
    (payload,) = world.received
    assert STORE.codec("geometry_msgs/Twist").decode(payload).linear.x == 2.0


def test_pub_refuses_more_than_a_bound(world: ZenohWorld, shell: Shell, tmp_path: Path) -> None:
    folder = tmp_path / "own_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Tag.msg").write_text("string<=3 name\nint32[<=2] numbers\n")
    command = ("topic", "pub", "-1", "-w", "0", "--msg-path", str(tmp_path), "/tag", "own_msgs/msg/Tag")
    assert "in field 'name', but ROS 2 allows at most 3" in shell.failure(*command, "{name: long}")
    assert "in field 'numbers', but ROS 2 allows at most 2" in shell.failure(*command, "{numbers: [1, 2, 3]}")
    assert "publishing #1" in shell.output(*command, "{name: arm, numbers: [1]}")


def test_pub_fills_defaults_and_counts(world: ZenohWorld, shell: Shell) -> None:
    out = shell.output(
        "topic", "pub", "-t", "3", "-r", "100", "-p", "2", "/goal", "geometry_msgs/Pose", "{position: {x: 1}}"
    )
    assert next(line for line in out.splitlines() if line.startswith("publishing")).startswith(
        "publishing #2: geometry_msgs.msg.Pose("
    )
    world.wait_until(lambda: len(world.received) == 3)
    poses = [STORE.codec("geometry_msgs/Pose").decode(payload) for payload in world.received]
    assert [(pose.position.x, pose.orientation.w) for pose in poses] == [(1.0, 1.0)] * 3


def test_pub_of_mistakes(world: ZenohWorld, shell: Shell) -> None:
    pub = ("topic", "pub", "-1")
    assert "nope" in shell.failure(*pub, "/x", "std_msgs/msg/String", "{nope: 1}")
    assert "std_msgs" in shell.failure(*pub, "/x", "std_msgs/msg/Strin", "{}")
    assert "has 0 of 1 subscribers after" in shell.failure(
        *pub, "--max-wait-time-secs", "0.05", "/x", "std_msgs/msg/String", "{}"
    )


@pytest.fixture
def measured(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """Measures a topic once; for longer on a busy machine, where too few messages arrive in a second."""

    def measure(pattern: str, *words: str) -> str:
        for period_s in (1.0, 10.0, 30.0):
            monkeypatch.setattr(meter, "REPORT_PERIOD_S", period_s)
            printed = shell.output("topic", *words, "-n", "1")
            if re.search(pattern, printed):
                return printed
        raise AssertionError(printed)

    return measure


def test_rates(world: ZenohWorld, measured: Callable[..., str]) -> None:
    measured(
        r"^Subscribed to \[/imu\]\naverage rate: \d+\.\d{3}\n"
        r"\tmin: .*s max: .*s std dev: .*s window: \d+\n$",
        *("hz", "/imu"),
    )
    measured(
        r"B/s from \d+ messages\n\tMessage size mean: (0\.32 KB min: 0\.32 KB max: 0\.32 KB|3\d\d B .*)\n",
        *("bw", "/imu"),
    )
    record = json.loads(measured("min_s", "delay", "--json", "/imu"))
    assert record["min_s"] > 1e9


def test_types_that_only_their_node_knows(
    world: ZenohWorld, shell: Shell, measured: Callable[..., str], tmp_path: Path
) -> None:
    registry = Registry(bundled=False)
    registry.add_full_text("far_msgs/Odd", "float64[4] values\n")
    publisher = world.do(world.board.advertise("/odd", registry.message_type("far_msgs/Odd")))

    async def talk() -> None:
        while True:
            publisher.publish_raw([bytes(32)])
            await asyncio.sleep(0.02)

    async def start() -> asyncio.Task[None]:
        return asyncio.ensure_future(talk())

    talking = world.do(start())
    try:
        measured("average rate: ", "hz", "/odd")
        # A slow machine publishes less than a kilobyte a second, which is shown in bytes.
        measured("Message size mean: (0.04 KB|36 B)", "bw", "/odd")
        error = shell.failure("topic", "echo", "--once", "/odd")
        assert "no ROS 2 package 'far_msgs' is known for far_msgs/msg/Odd" in error
        assert "the bundled definitions of jazzy" in error
        assert (
            "its node does not describe it: no node offers the service /far/board/get_type_description"
            in error
        )
        described, raw = tmp_path / "described", tmp_path / "raw"
        shell.output("bag", "record", "-O", str(raw), "-l", "2", "--duration", "60", "/odd")
        world.do(_describe_odd(world))
        assert shell.output("topic", "echo", "--once", "/odd").startswith("values:\n- 0.0\n- 0.0\n")
        shell.output("bag", "record", "-O", str(described), "-l", "2", "--duration", "60", "/odd")
    finally:
        world.stop(talking)
        world.do(publisher.close())
    schemas = []
    for folder in (raw, described):
        with (folder / f"{folder.name}_0.mcap").open("rb") as stream:
            (found,) = list(make_reader(stream).iter_messages())[:1]
            schema, channel, message = found
            assert schema is not None
            schemas.append((schema.name, schema.encoding, schema.data.decode()))
            assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
            assert message.data == b"\x00\x01\x00\x00" + bytes(32)
    assert schemas == [
        ("far_msgs/msg/Odd", "unknown", ""),
        ("far_msgs/msg/Odd", "ros2msg", "float64[4] values\n"),
    ]


async def _describe_odd(world: ZenohWorld) -> None:
    """Offer the board's service that describes the type far_msgs/msg/Odd."""
    types = world.session.types
    service_type = types.native_service(SERVICE_TYPE)
    store = TypeStore(NativeRegistry.from_environment(environ={}))

    async def answer(request: bytes) -> bytes:
        asked = store.codec(service_type.request.name).decode(request)
        assert asked.type_name == "far_msgs/msg/Odd"
        field = {"name": "values", "type": {"type_id": 11 + 48, "capacity": 4}}
        description = {"type_description": {"type_name": asked.type_name, "fields": [field]}}
        return store.codec(service_type.response.name).encode(
            {"successful": True, "type_description": description}
        )

    await world.board.advertise_service(f"/far/board/{SERVICE}", service_type, answer)


def test_options_of_one_ros_only(world: ZenohWorld, shell: Shell) -> None:
    assert "--host works on ROS 1 only" in shell.failure("topic", "list", "--host", code=2)
    assert "--master works on ROS 1 only" in shell.failure(
        "topic", "echo", "--master", "http://x:1", "/x", code=2
    )
    assert "--csv works on ROS 2 only" in shell.failure("topic", "echo", "--ros1", "--csv", "/x", code=2)
    assert "--truncate-length works on ROS 2 only" in shell.failure(
        "topic", "echo", "--ros1", "-l", "0", "/x", code=2
    )
    assert "node kill` works on ROS 1 only" in shell.failure("node", "kill", "/far/board", code=2)
    assert "service uri` works on ROS 1 only" in shell.failure("service", "uri", "/set_led", code=2)

from __future__ import annotations

from collections.abc import Sequence

import pytest

from rostether.graph.ports import ServiceServer
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.parse import parse_service
from rostether.msgdef.ros2.spec import Ros2Message
from rostether.ros2.type_description import SERVICE, SERVICE_TYPE
from rostether.ros2.types import type_hash
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.type_hash import service_messages
from rostether.serde.store import TypeStore
from unit.cli.command_shell import Shell
from unit.cli.ros2.zenoh_world import ZenohWorld

pytestmark = pytest.mark.slow


def test_node_list(world: ZenohWorld, shell: Shell) -> None:
    assert shell.output("node", "list") == "/far/board\n"
    assert shell.output("node", "list", "-c") == "1\n"
    assert shell.output("node", "list", "/near") == ""
    assert shell("node", "list", "--json").records == [{"node": "/far/board"}]
    hidden = world.do(world.session.join("/_hidden"))
    try:
        assert shell.output("node", "list") == "/far/board\n"
        assert shell.output("node", "list", "-a") == "/_hidden\n/far/board\n"
    finally:
        world.do(hidden.close())


def test_node_info(world: ZenohWorld, shell: Shell) -> None:
    services = "".join(
        f"    /far/board/{verb}: rcl_interfaces/srv/{kind}\n"
        for verb, kind in (
            ("describe_parameters", "DescribeParameters"),
            ("get_parameter_types", "GetParameterTypes"),
            ("get_parameters", "GetParameters"),
            ("list_parameters", "ListParameters"),
            ("set_parameters", "SetParameters"),
            ("set_parameters_atomically", "SetParametersAtomically"),
        )
    )
    assert shell.output("node", "info", "/far/board") == (
        "/far/board\n"
        "  Subscribers:\n"
        "    /cmd_vel: geometry_msgs/msg/Twist\n"
        "    /goal: geometry_msgs/msg/Pose\n"
        "  Publishers:\n"
        "    /imu: sensor_msgs/msg/Imu\n"
        "    /name: std_msgs/msg/String\n"
        "    /parameter_events: rcl_interfaces/msg/ParameterEvent\n"
        "    /rosout: rcl_interfaces/msg/Log\n"
        "  Service Servers:\n"
        f"{services}"
        "    /set_led: std_srvs/srv/SetBool\n"
        "  Service Clients:\n\n"
        "  Action Servers:\n\n"
        "  Action Clients:\n\n"
    )
    assert "/_raw" in shell.output("node", "info", "--include-hidden", "/far/board")
    assert "Unable to find node '/nope'" in shell.failure("node", "info", "nope")
    assert "did you mean /far/board?" in shell.failure("node", "info", "/far/bord")
    assert "did you mean /set_led?" in shell.failure("service", "info", "/set_let")
    assert "did you mean gain?" in shell.failure("param", "get", "/far/board", "gian")
    assert "did you mean /far/board?" in shell.failure("param", "get", "/far/boat", "gain")


def test_service_list(world: ZenohWorld, shell: Shell) -> None:
    assert "/set_led [std_srvs/srv/SetBool]" in shell.output("service", "list", "-t").splitlines()
    assert shell.output("service", "list", "-n", "/set_led") == "/set_led /far/board\n"
    assert shell.output("service", "list", "-c") == "7\n"
    assert shell.output("service", "type", "/set_led") == "std_srvs/srv/SetBool\n"
    assert shell.output("service", "find", "std_srvs/SetBool") == "/set_led\n"
    assert shell.output("service", "node", "/set_led") == "/far/board\n"
    assert shell.output("service", "args", "/set_led") == "data\n"
    assert shell.output("service", "info", "/set_led") == (
        "Type: std_srvs/srv/SetBool\nClients count: 0\nServices count: 1\n"
    )
    assert "Unknown service '/nope'" in shell.failure("service", "type", "/nope")


def test_service_call(world: ZenohWorld, shell: Shell) -> None:
    expected = (
        "requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\n"
        "response:\n"
        "std_srvs.srv.SetBool_Response(success=True, message='it is on')\n\n"
    )
    for words in (("std_srvs/srv/SetBool", "{data: true}"), ("{data: true}",)):
        printed = shell.output("service", "call", "/set_led", *words)
        # The service may become known only after the command has started to wait.
        assert printed.removeprefix("waiting for service to become available...\n") == expected
    assert shell("service", "call", "--json", "/set_led", "std_srvs/SetBool").records == [
        {"success": False, "message": ""}
    ]
    assert "nope" in shell.failure("service", "call", "/set_led", "{nope: 1}")
    result = shell("service", "call", "--timeout", "0.3", "/nope")
    assert (result.code, result.out) == (1, "waiting for service to become available...\n")
    assert "no node offered the service /nope within 0.3 s" in result.err


def test_definitions(shell: Shell) -> None:
    assert shell.output("msg", "show", "--ros2", "zenoh", "std_msgs/msg/Header") == (
        "builtin_interfaces/Time stamp\n\tint32 sec\n\tuint32 nanosec\nstring frame_id\n"
    )
    assert shell.output("srv", "show", "--ros2", "zenoh", "std_srvs/SetBool") == (
        "bool data\n---\nbool success\nstring message\n"
    )
    assert shell.output("msg", "show", "--ros2", "zenoh", "Quaternion") == (
        "[geometry_msgs/msg/Quaternion]:\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"
    )
    assert shell.output("msg", "md5", "--ros2", "zenoh", "std_msgs/String").startswith("RIHS01_df668c74")
    assert (
        "std_srvs/srv/SetBool" in shell.output("srv", "package", "--ros2", "zenoh", "std_srvs").splitlines()
    )
    assert "did you mean" in shell.failure("msg", "show", "--ros2", "zenoh", "Strin")


def test_a_service_whose_type_only_its_node_knows(world: ZenohWorld, shell: Shell) -> None:
    here = Registry(bundled=False)
    here.add_full_text("far_msgs/FillRequest", "uint8 level\n")
    here.add_full_text("far_msgs/FillResponse", "string[] tanks\n")
    fill = parse_service("uint8 level\n---\nstring[] tanks\n", package="far_msgs", name="Fill")
    world.session.types.definitions.add(fill.parts)
    fill_type = world.session.types.native_service("far_msgs/srv/Fill")

    async def answer(request: bytes) -> bytes:
        return TypeStore(here).codec("far_msgs/FillResponse").encode({"tanks": ["left"] * request[0]})

    server = world.do(world.board.advertise_service("/fill", fill_type, answer))
    try:
        error = shell.failure("service", "call", "/fill", "{level: 2}")
        assert "no ROS 2 package 'far_msgs' is known for far_msgs/srv/Fill" in error
        assert "(searched: " in error
        assert "no node offers the service /far/board/get_type_description" in error
        describer = world.do(describe(world, service_messages(fill)))
        try:
            shown = shell.output("service", "call", "/fill", "{level: 2}")
        finally:
            world.do(describer.close())
        assert shown.endswith("response:\nfar_msgs.srv.Fill_Response(tanks=['left', 'left'])\n\n")
    finally:
        world.do(server.close())


async def describe(world: ZenohWorld, messages: Sequence[Ros2Message]) -> ServiceServer:
    """Offer the board's service that describes a type by its messages, and by those of the standard types."""
    service_type = world.session.types.native_service(SERVICE_TYPE)
    registry = NativeRegistry.from_environment(environ={})
    known = ("service_msgs/msg/ServiceEventInfo", "builtin_interfaces/msg/Time")
    whole, *below = [*messages, *map(registry.definitions.message, known)]
    description = {
        "type_description": type_hash.describe(whole),
        "referenced_type_descriptions": [type_hash.describe(each) for each in below],
    }
    codec = TypeStore(registry).codec(service_type.response.name)
    response = codec.encode({"successful": True, "type_description": description})

    async def answer(_request: bytes) -> bytes:
        return response

    return await world.board.advertise_service(f"/far/board/{SERVICE}", service_type, answer)

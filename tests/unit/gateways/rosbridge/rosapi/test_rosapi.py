from __future__ import annotations

import json
from collections.abc import AsyncIterator
from typing import Any

import pytest
from msgspec.structs import replace

from rostether.errors import (
    AccessDeniedError,
    RostetherError,
    SerializationError,
    ServiceUnavailableError,
)
from rostether.gateways.rosbridge.form_source import Style
from rostether.gateways.rosbridge.rosapi.rosapi import Rosapi, offering_rosapi
from rostether.gateways.rosbridge.settings import RosbridgeSettings
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Snapshot
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.interface import ANY_TYPE
from rostether.msgdef.registry import Registry
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.rostime import Time
from rostether.serde.store import TypeStore

NOW = Time(1_700_000_000, 7)
STORE = TypeStore(Registry())

# The md5sums of the package rosapi of ROS Noetic, from its generated code.
MD5SUMS = {
    "DeleteParam": "c1f3d28f1b044c871e6eff2e9fc3c667",
    "GetActionServers": "46807ba271844ac5ba4730a47556b236",
    "GetParam": "e36fd90759dbac1c5159140a7fa8c644",
    "GetParamNames": "dc7ae3609524b18034e49294a4ce670e",
    "GetTime": "556a4fb76023a469987922359d08a844",
    "HasParam": "ed3df286bd6dff9b961770f577454ea9",
    "MessageDetails": "f9c88144f6f6bd888dd99d4e0411905d",
    "NodeDetails": "e1d0ced5ab8d5edb5fc09c98eb1d46f6",
    "Nodes": "3d07bfda1268b4f76b16b7ba8a82665d",
    "Publishers": "cb37f09944e7ba1fc08ee38f7a94291d",
    "SearchParam": "dfadc39f113c1cc6d7759508d8461d5a",
    "ServiceHost": "a1b60006f8ee69637c856c94dd192f5a",
    "ServiceNode": "bd2a0a45fd7a73a86c8d6051d5a6db8a",
    "ServiceProviders": "f30b41d5e347454ae5483ee95eef5cc6",
    "ServiceRequestDetails": "f9c88144f6f6bd888dd99d4e0411905d",
    "ServiceResponseDetails": "f9c88144f6f6bd888dd99d4e0411905d",
    "ServiceType": "0e24a2dcdf70e483afc092a35a1f15f7",
    "Services": "e44a7e7bcb900acadbcc28b132378f0c",
    "ServicesForType": "93e9fe8ae5a9136008e260fe510bd2b0",
    "SetParam": "bc6ccc4a57f61779c8eaae61e9f422e0",
    "Subscribers": "cb387b68f5b29bc1456398ee8476b973",
    "TopicType": "0d30b3f53a0fd5036523a7141e524ddf",
    "Topics": "d966d98fc333fa1f3135af765eac1ba8",
    "TopicsAndRawTypes": "e1432466c8f64316723276ba07c59d12",
    "TopicsForType": "56f77ff6da756dd27c1ed16ec721072a",
}


@pytest.mark.parametrize("name", MD5SUMS)
def test_definitions_are_those_of_the_established_package(name: str) -> None:
    assert STORE.registry.service_type(f"rosapi/{name}").md5sum == MD5SUMS[name]


@pytest.fixture
async def network() -> AsyncIterator[MemoryNetwork]:
    network = MemoryNetwork(now=lambda: NOW)
    yield network
    for graph in list(network.nodes.values()):
        await graph.close()


@pytest.fixture
async def gateway(network: MemoryNetwork) -> MemoryGraph:
    return await network.join("/gateway")


@pytest.fixture
async def talker(network: MemoryNetwork) -> TypedGraph:
    graph = TypedGraph(await network.join("/talker"), STORE)
    await graph.publisher("/chatter", "std_msgs/String")
    await graph.publisher("/pose", "geometry_msgs/PoseStamped")
    await graph.service_server("/enable", "std_srvs/SetBool", lambda _: {})
    return graph


async def known_types(service: str) -> str:
    if service != "/enable":
        raise ServiceUnavailableError(f"{service} does not answer")
    return "std_srvs/SetBool"


class ForgetfulGraph(MemoryGraph):
    """A graph that does not know the types of services, like that of ROS 1."""

    async def snapshot(self) -> Snapshot:
        found = await super().snapshot()
        services = {name: replace(each, type=ANY_TYPE) for name, each in found.services.items()}
        return replace(found, services=services)


def api_of(gateway: MemoryGraph, style: Style = Style.ROS1, **settings: Any) -> Rosapi:
    return Rosapi(
        gateway,
        STORE,
        style=style,
        settings=RosbridgeSettings(**settings),
        ask_type=known_types,
        ask_host=known_types,
        environ={},
    )


async def ask(api: Rosapi, service: str, /, **args: Any) -> Any:
    local = api.find(f"/rosapi/{service}")
    assert local is not None
    return await local(args)


async def test_topics_with_their_types(gateway: MemoryGraph, talker: TypedGraph) -> None:
    api = api_of(gateway)
    assert await ask(api, "topics") == {
        "topics": ["/chatter", "/pose", "/rosout"],
        "types": ["std_msgs/String", "geometry_msgs/PoseStamped", "rosgraph_msgs/Log"],
    }
    assert await ask(api, "topics_for_type", type="std_msgs/String") == {"topics": ["/chatter"]}
    assert await ask(api, "topics_for_type", type="std_msgs/msg/String") == {"topics": ["/chatter"]}
    assert await ask(api, "topic_type", topic="/pose") == {"type": "geometry_msgs/PoseStamped"}
    assert await ask(api, "topic_type", topic="chatter") == {"type": "std_msgs/String"}
    assert await ask(api, "topic_type", topic="/none") == {"type": ""}
    raw = await ask(api, "topics_and_raw_types")
    assert raw["typedefs_full_text"][0] == STORE.registry.message_type("std_msgs/String").definition
    assert "MSG: std_msgs/Header" in raw["typedefs_full_text"][1]


async def test_nodes_and_what_they_do(gateway: MemoryGraph, talker: TypedGraph) -> None:
    api = api_of(gateway)
    await gateway.subscribe("/chatter", STORE.registry.message_type("std_msgs/String"), lambda _: None)
    assert await ask(api, "nodes") == {"nodes": ["/gateway", "/talker"]}
    assert await ask(api, "node_details", node="/talker") == {
        "subscribing": [],
        "publishing": ["/chatter", "/pose", "/rosout"],
        "services": ["/enable"],
    }
    assert (await ask(api, "node_details", node="gateway"))["subscribing"] == ["/chatter"]
    assert await ask(api, "publishers", topic="/chatter") == {"publishers": ["/talker"]}
    assert await ask(api, "subscribers", topic="/chatter") == {"subscribers": ["/gateway"]}
    assert await ask(api, "subscribers", topic="/none") == {"subscribers": []}


async def test_services_and_their_types(gateway: MemoryGraph, talker: TypedGraph) -> None:
    api = api_of(gateway)
    assert await ask(api, "services") == {"services": ["/enable"]}
    assert await ask(api, "service_type", service="/enable") == {"type": "std_srvs/SetBool"}
    assert await ask(api, "service_type", service="/none") == {"type": ""}
    assert await ask(api, "services_for_type", type="std_srvs/SetBool") == {"services": ["/enable"]}
    assert await ask(api, "services_for_type", type="std_srvs/srv/SetBool") == {"services": ["/enable"]}
    assert await ask(api, "service_node", service="/enable") == {"node": "/talker"}
    assert await ask(api, "service_node", service="/none") == {"node": ""}
    assert await ask(api, "service_providers", service="/enable") == {"providers": ["/talker"]}
    assert await ask(api, "service_providers", service="std_srvs/SetBool") == {"providers": ["/talker"]}
    assert await ask(api, "service_host", service="/enable") == {"host": "std_srvs/SetBool"}


async def test_a_service_that_starts_during_a_request_is_no_error(
    gateway: MemoryGraph, talker: TypedGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = await gateway.snapshot()
    later = iter([replace(now, services={})])

    async def snapshot() -> Snapshot:
        return next(later, now)

    monkeypatch.setattr(gateway, "snapshot", snapshot)
    request = {"service": "std_srvs/SetBool"}
    assert await ask(api_of(gateway), "service_providers", **request) == {"providers": []}
    assert await ask(api_of(gateway), "service_providers", **request) == {"providers": ["/talker"]}


async def test_servers_are_asked_where_the_graph_knows_no_types(
    network: MemoryNetwork, talker: TypedGraph
) -> None:
    await talker.service_server("/dumb", "std_srvs/Empty", lambda _: {})
    graph = ForgetfulGraph(network, "/forgetful", "/", {})
    api = api_of(graph)
    assert await ask(api, "service_type", service="/enable") == {"type": "std_srvs/SetBool"}
    assert await ask(api, "services_for_type", type="std_srvs/SetBool") == {"services": ["/enable"]}
    assert await ask(api, "service_type", service="/dumb") == {"type": ""}
    api = Rosapi(graph, STORE)
    assert await ask(api, "service_type", service="/enable") == {"type": ""}
    assert await ask(api, "service_host", service="/enable") == {"host": ""}


async def test_details_of_types_hold_the_types_below(gateway: MemoryGraph) -> None:
    api = api_of(gateway)
    details = (await ask(api, "message_details", type="geometry_msgs/PolygonStamped"))["typedefs"]
    assert [each["type"] for each in details] == [
        "geometry_msgs/PolygonStamped",
        "std_msgs/Header",
        "time",
        "geometry_msgs/Polygon",
        "geometry_msgs/Point32",
    ]
    assert details[3] == {
        "type": "geometry_msgs/Polygon",
        "fieldnames": ["points"],
        "fieldtypes": ["geometry_msgs/Point32"],
        "fieldarraylen": [0],
        "examples": ["[]"],
        "constnames": [],
        "constvalues": [],
    }
    request = (await ask(api, "service_request_details", type="std_srvs/SetBool"))["typedefs"]
    assert (request[0]["type"], request[0]["fieldtypes"]) == ("std_srvs/SetBoolRequest", ["bool"])
    response = (await ask(api, "service_response_details", type="std_srvs/srv/SetBool"))["typedefs"]
    assert response[0]["fieldnames"] == ["success", "message"]
    log = (await ask(api, "message_details", type="rosgraph_msgs/Log"))["typedefs"][0]
    assert dict(zip(log["constnames"], log["constvalues"], strict=True))["FATAL"] == "16"
    array = (await ask(api, "message_details", type="sensor_msgs/CameraInfo"))["typedefs"][0]
    assert dict(zip(array["fieldnames"], array["fieldarraylen"], strict=True))["K"] == 9


async def test_an_unknown_type_is_reported(gateway: MemoryGraph) -> None:
    with pytest.raises(RostetherError, match="no_msgs"):
        await ask(api_of(gateway), "message_details", type="no_msgs/Nothing")


async def test_actions_are_found_by_their_topics(gateway: MemoryGraph, talker: TypedGraph) -> None:
    for topic in ("goal", "cancel", "status", "feedback", "result"):
        await talker.publisher(f"/fibonacci/{topic}", "std_msgs/String")
    await talker.publisher("/half/goal", "std_msgs/String")
    assert await ask(api_of(gateway), "action_servers") == {"action_servers": ["/fibonacci"]}


async def test_time_and_version(gateway: MemoryGraph) -> None:
    api = api_of(gateway)
    assert await ask(api, "get_time") == {"time": {"secs": NOW.secs, "nsecs": NOW.nsecs}}
    assert await ask(api, "get_ros_version") == {"version": 1, "distro": "noetic"}
    await gateway.set_param("/rosdistro", "melodic\n")
    assert await ask(api, "get_ros_version") == {"version": 1, "distro": "melodic"}


@pytest.mark.parametrize("value", [1, -2.5, True, "hello", [1, "a"], {"a": {"b": [1]}}])
async def test_parameters_travel_as_json(gateway: MemoryGraph, value: Any) -> None:
    api = api_of(gateway)
    assert await ask(api, "set_param", name="/x", value=json.dumps(value)) == {}
    assert await gateway.get_param("/x") == value
    assert json.loads((await ask(api, "get_param", name="/x"))["value"]) == value
    assert await ask(api, "has_param", name="/x") == {"exists": True}
    assert "/x" in str((await ask(api, "get_param_names"))["names"])
    assert await ask(api, "search_param", name="x") == {"global_name": "/x"}
    assert await ask(api, "delete_param", name="/x") == {}
    assert await ask(api, "delete_param", name="/x") == {}
    assert await ask(api, "has_param", name="/x") == {"exists": False}


async def test_defaults_of_parameters(gateway: MemoryGraph) -> None:
    api = api_of(gateway)
    assert await ask(api, "get_param", name="/none") == {"value": "null"}
    assert await ask(api, "get_param", name="/none", default="5") == {"value": "5"}
    assert await ask(api, "get_param", name="/none", default="plain") == {"value": '"plain"'}
    assert await ask(api, "search_param", name="none") == {"global_name": ""}


@pytest.mark.parametrize(
    "value", ["", "plain", "{", "null", '[1, {"a": null}]', "[" * 100_000, "[" * 200 + "]" * 200]
)
async def test_a_value_that_is_not_json_is_reported(gateway: MemoryGraph, value: str) -> None:
    with pytest.raises(SerializationError) as error:
        await ask(api_of(gateway), "set_param", name="/x", value=value)
    assert len(str(error.value)) < 300
    assert not await gateway.has_param("/x")


async def test_what_clients_may_not_use_is_hidden(gateway: MemoryGraph, talker: TypedGraph) -> None:
    await gateway.set_param("/secret", 1)
    api = api_of(gateway, topics_glob=("/pose",), services_glob=(), params_glob=("/open*",))
    assert (await ask(api, "topics"))["topics"] == ["/pose"]
    assert await ask(api, "publishers", topic="/chatter") == {"publishers": []}
    assert await ask(api, "services") == {"services": []}
    assert await ask(api, "service_node", service="/enable") == {"node": ""}
    assert await ask(api, "has_param", name="/secret") == {"exists": False}
    assert await ask(api, "get_param_names") == {"names": []}
    for name, args in (("get_param", {}), ("set_param", {"value": "2"}), ("delete_param", {})):
        with pytest.raises(AccessDeniedError):
            await ask(api, name, name="/secret", **args)


async def test_requests_may_be_lists_and_must_fit(gateway: MemoryGraph, talker: TypedGraph) -> None:
    local = api_of(gateway).find("/rosapi/topic_type")
    assert local is not None
    assert await local(["/chatter"]) == {"type": "std_msgs/String"}
    assert await local(None) == {"type": ""}
    for args in ({"topic": 5}, {"topics": ""}, ["a", "b"], 7):
        with pytest.raises(RostetherError):
            await local(args)


async def test_it_is_a_node_of_the_graph(
    network: MemoryNetwork, gateway: MemoryGraph, talker: TypedGraph
) -> None:
    api = api_of(gateway)
    async with offering_rosapi(api, network.join, gateway) as is_ours:
        assert is_ours
        found = await talker.call("/rosapi/topic_type", "rosapi/TopicType", {"topic": "/chatter"})
        assert found.type == "std_msgs/String"
        assert await ask(api, "service_type", service="/rosapi/nodes") == {"type": "rosapi/Nodes"}
        assert set(api.services) <= set((await ask(api, "services"))["services"])
        async with offering_rosapi(api, network.join, gateway) as is_ours:
            assert not is_ours
    assert "/rosapi" not in (await gateway.snapshot()).nodes


async def test_words_of_ros2(gateway: MemoryGraph, talker: TypedGraph) -> None:
    store = TypeStore(NativeRegistry.from_environment(environ={}))
    for api in (Rosapi(gateway, store, style=Style.ROS2, environ={}), api_of(gateway, Style.ROS2)):
        assert (await ask(api, "topics"))["types"][:2] == [
            "std_msgs/msg/String",
            "geometry_msgs/msg/PoseStamped",
        ]
        assert await ask(api, "get_time") == {"time": {"sec": NOW.secs, "nanosec": NOW.nsecs}}
        assert await ask(api, "get_ros_version") == {"version": 2, "distro": "jazzy"}
        texts = (await ask(api, "topics_and_raw_types"))["typedefs_full_text"]
        assert "MSG: std_msgs/Header\n" in texts[1]
        assert "seq" not in texts[1]
    native = Rosapi(gateway, store, style=Style.ROS2, environ={})
    assert native.services["/rosapi/topics"] == "rosapi_msgs/Topics"
    assert native.find("/rosapi/search_param") is None
    assert await ask(native, "set_param", name="/talker:speed", value="1") == {
        "successful": True,
        "reason": "",
    }
    assert await gateway.get_param("/talker/speed") == 1
    assert (await ask(native, "get_param_names"))["names"] == ["/talker:speed"]
    assert await ask(native, "get_param", name="/talker:none", default="4") == {
        "value": "4",
        "successful": True,
        "reason": "",
    }
    failed = await ask(native, "set_param", name="/talker:speed", value="{")
    assert not failed["successful"]
    assert "JSON" in failed["reason"]

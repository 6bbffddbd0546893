from __future__ import annotations

import pytest
from msgspec.structs import replace

from rostether.bridge.endpoint.factory import EndpointFactory
from rostether.bridge.endpoint.publisher import PublisherEndpoint
from rostether.bridge.endpoint.service_client import ServiceClientEndpoint
from rostether.bridge.endpoint.service_server import ServiceServerEndpoint
from rostether.bridge.endpoint.subscriber import SubscriberEndpoint
from rostether.bridge.settings import DEFAULT_SETTINGS
from rostether.errors import TypeMismatchError, UnknownTypeError
from rostether.rosserial.events import ServiceRole, TopicAnnounced, TopicRole
from unit.bridge.doubles import FakeLine
from unit.bridge.nodes import STORE, World, publisher, service, subscriber, topic_info
from waiting import until


@pytest.fixture
async def factory() -> EndpointFactory:
    world = await World().open()
    return EndpointFactory(world.board, STORE, world.notices, DEFAULT_SETTINGS)


async def test_each_role_has_its_endpoint(factory: EndpointFactory) -> None:
    assert isinstance(factory.topic(publisher()), PublisherEndpoint)
    assert isinstance(factory.topic(subscriber()), SubscriberEndpoint)
    assert isinstance(factory.service(service(ServiceRole.SERVER)), ServiceServerEndpoint)
    assert isinstance(factory.service(service(ServiceRole.CLIENT)), ServiceClientEndpoint)


async def test_a_type_of_no_known_package(factory: EndpointFactory) -> None:
    info = replace(topic_info(), message_type="my_robot/Arm")
    with pytest.raises(UnknownTypeError, match="my_robot"):
        factory.topic(TopicAnnounced(TopicRole.PUBLISHER, info))
    with pytest.raises(UnknownTypeError, match="my_robot"):
        factory.service(replace(service(ServiceRole.SERVER), type="my_robot/Grip"))


async def test_the_difference_of_a_definition_is_searched_once(
    factory: EndpointFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def explain(_types: object, name: str, md5sum: str) -> str:
        asked.append(md5sum)
        return f"{name}: {md5sum} is not ours"

    monkeypatch.setattr("rostether.msgdef.mismatch.explain_mismatch", explain)
    for _ in range(3):
        with pytest.raises(TypeMismatchError, match="is not ours"):
            factory.topic(TopicAnnounced(TopicRole.PUBLISHER, topic_info(md5sum="f" * 32)))
    assert asked == ["f" * 32]


async def test_another_definition_is_reported_with_both_md5sums(factory: EndpointFactory) -> None:
    ours = STORE.registry.message_type("sensor_msgs/Range").md5sum
    info = topic_info("range", "sensor_msgs/Range", md5sum="0" * 32)
    with pytest.raises(TypeMismatchError) as caught:
        factory.topic(TopicAnnounced(TopicRole.PUBLISHER, info))
    assert ours in str(caught.value)
    assert "0" * 32 in str(caught.value)


async def test_the_empty_response_has_the_responses_layout() -> None:
    world = await World().open()
    factory = EndpointFactory(world.board, STORE, world.notices, DEFAULT_SETTINGS)
    client = factory.service(service(ServiceRole.CLIENT, type_name="rosserial_arduino/Test"))
    line = FakeLine()
    assert isinstance(client, ServiceClientEndpoint)
    client.attach(line, client.info)
    line.receivers[110]([b"\0\0\0\0"])
    await until(lambda: line.transport.written, "the empty response")
    assert line.transport.written == b"111:\0\0\0\0;"


@pytest.mark.parametrize("type_name", ["tf2_msgs/TFMessage", "tf/tfMessage"])
async def test_static_transforms_are_latched_and_later_subscribers_receive_all(type_name: str) -> None:
    world = await World().open()
    line = FakeLine()
    endpoint = EndpointFactory(world.board, STORE, world.notices, DEFAULT_SETTINGS).topic(
        TopicAnnounced(TopicRole.PUBLISHER, topic_info("tf_static", type_name))
    )
    endpoint.attach(line, endpoint.info)
    await endpoint.open()
    codec = STORE.codec(type_name)
    for frame in ("lidar", "camera"):
        line.receivers[125]([codec.encode({"transforms": [{"child_frame_id": frame}]})])
    received = await world.listen("/tf_static", type_name)
    await until(lambda: received, "the latched message")
    frames = [each.child_frame_id for each in codec.decode(received[0]).transforms]
    assert frames == ["lidar", "camera"]

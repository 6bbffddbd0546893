"""Topics of Foxglove clients, over real sockets."""

from __future__ import annotations

from rostether.msgdef.registry import Registry
from unit.gateways.foxglove.protocol_client import STRING, stage, string_type, text
from waiting import until


async def test_messages_come_as_they_are_only_while_subscribed() -> None:
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/chatter", string_type(there))
        channel = await client.channel("/chatter")
        assert publisher.subscriber_count == 0
        await client.say("subscribe", subscriptions=[{"id": 5, "channelId": channel["id"]}])
        await until(lambda: publisher.subscriber_count)
        payloads = [text(there, "x" * size) for size in (0, 100, 200, 70_000)]
        publisher.publish_raw(payloads)
        await client.wait("messageData", lambda message: message["payload"] == payloads[-1])
        arrived = client.of("messageData")
        assert [message["payload"] for message in arrived] == payloads
        assert {message["id"] for message in arrived} == {5}
        await client.say("unsubscribe", subscriptionIds=[5])
        await until(lambda: publisher.subscriber_count == 0)


async def test_a_late_client_gets_what_was_latched_and_the_first_does_not_again() -> None:
    async with stage() as there, there.client() as first:
        publisher = await there.robot.advertise("/map", string_type(there), latch=True)
        publisher.publish_raw([text(there, "map")])
        channel = await first.channel("/map")
        await first.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
        await first.wait("messageData")
        async with there.client() as second:
            await second.say("subscribe", subscriptions=[{"id": 9, "channelId": channel["id"]}])
            assert (await second.wait("messageData"))["id"] == 9
        await until(lambda: there.connection_count == 1)
        assert publisher.subscriber_count == 1
        assert len(first.of("messageData")) == 1


async def test_a_topic_that_ends_is_removed_with_its_subscriptions() -> None:
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/chatter", string_type(there))
        channel = await client.channel("/chatter")
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
        await until(lambda: publisher.subscriber_count)
        await publisher.close()
        await client.wait("unadvertise", lambda message: message["channelIds"] == [channel["id"]])
        await until(lambda: not there.gateway.context.shared._sources)
        await there.robot.advertise("/chatter", string_type(there))
        again = await client.channel("/chatter", after=channel["id"])
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": again["id"]}])
        await until(lambda: there.gateway.context.shared._sources)


async def test_a_type_that_is_not_known_is_learned_from_its_publisher() -> None:
    registry = Registry(bundled=False)
    registry.add_full_text("mine/Odd", "int32 a\nmine/Part part\n" + "=" * 80 + "\nMSG: mine/Part\nuint8 b\n")
    odd = registry.message_type("mine/Odd")
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/odd", odd)
        channel = await client.channel("/odd")
        assert channel["schema"] == odd.definition
        await until(lambda: publisher.subscriber_count == 0)
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
        await until(lambda: publisher.subscriber_count)
        publisher.publish_raw([b"\1\0\0\0\2"])
        assert (await client.wait("messageData"))["payload"] == b"\1\0\0\0\2"


async def test_a_publisher_with_another_definition_gets_a_channel_of_its_definition() -> None:
    registry = Registry(bundled=False)
    registry.add_full_text(STRING, "int32 number\n")
    other = registry.message_type(STRING)
    async with stage() as there, there.client() as client:
        publisher = await there.robot.advertise("/chatter", other)
        channel = await client.channel("/chatter")
        assert channel["schema"] == "string data\n"
        await client.say("subscribe", subscriptions=[{"id": 1, "channelId": channel["id"]}])
        again = await client.channel("/chatter", after=channel["id"])
        assert again["schema"] == "int32 number\n"
        await client.say("subscribe", subscriptions=[{"id": 2, "channelId": again["id"]}])

        def is_received() -> bool:
            # The subscription of the ended channel may still exist.
            publisher.publish_raw([b"\1\0\0\0"])
            return bool(client.of("messageData"))

        await until(is_received)
        assert {each["id"] for each in client.of("messageData")} == {2}


async def test_a_client_publishes_raw_and_json() -> None:
    async with stage() as there, there.client() as client:
        arrived: list[bytes] = []
        await there.robot.subscribe("/cmd", string_type(there), arrived.extend)
        channels = [
            {"id": 1, "topic": "/cmd", "encoding": "ros1", "schemaName": STRING},
            {"id": 2, "topic": "/cmd", "encoding": "json", "schemaName": "std_msgs/msg/String"},
        ]
        await client.say("advertise", channels=channels)
        # Immediately: messages are kept until the graph has the topic.
        await client.publish(1, text(there, "raw"))
        await client.publish(2, b'{"data": "json"}')
        await until(lambda: len(arrived) == 2)
        assert sorted(arrived) == sorted([text(there, "raw"), text(there, "json")])
        await client.publish(1, b"\xff\xff\xff\xff")
        assert "/cmd is not published" in (await client.wait("status"))["message"]
        await client.say("unadvertise", channelIds=[1, 2])
        await client.wait("unadvertise")
    assert len(arrived) == 2


async def test_messages_sent_before_a_client_leaves_are_published() -> None:
    async with stage() as there, there.client() as client:
        arrived: list[bytes] = []
        await there.robot.subscribe("/said", string_type(there), arrived.extend)
        channel = {"id": 1, "topic": "/said", "encoding": "ros1", "schemaName": STRING}
        await client.say("advertise", channels=[channel])
        await client.publish(1, text(there, "bye"))
        await client.say("unadvertise", channelIds=[1])
        await until(lambda: arrived == [text(there, "bye")])

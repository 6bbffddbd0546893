"""rostether's publishers and subscribers with those of rospy, roscpp and the tools, with rostether's master
and with roscore.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from contract.graphs import BOOL, STRING, Inbox, string
from interop.node_stage import ON_BOTH_MASTERS, Stage, stage_on
from rostether.msgdef.interface import ANY_MESSAGE
from waiting import until

SUBSCRIBE = """
import sys, rospy
from std_msgs.msg import String
rospy.init_node("py_listener")
count = int(sys.argv[2])
def handle(message):
    global count
    print(message._connection_header["callerid"], message.data, flush=True)
    count -= 1
    if count == 0:
        rospy.signal_shutdown("done")
rospy.Subscriber(sys.argv[1], String, handle, tcp_nodelay=True)
rospy.spin()
"""

PUBLISH = """
import sys, time, rospy
from std_msgs.msg import String
rospy.init_node("py_talker")
publisher = rospy.Publisher(sys.argv[1], String, queue_size=None, latch=sys.argv[2] == "latch")
while sys.argv[2] != "latch" and publisher.get_num_connections() == 0:
    time.sleep(0.01)
for number in range(int(sys.argv[3])):
    publisher.publish(sys.argv[4] % number if "%" in sys.argv[4] else sys.argv[4])
print("sent", flush=True)
rospy.spin()
"""

ECHO_ANY = """
import sys, rospy
rospy.init_node("py_any")
message = rospy.wait_for_message(sys.argv[1], rospy.AnyMsg, 60)
print(message._connection_header["type"], message._buff.hex(), flush=True)
"""


@pytest_asyncio.fixture
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on(getattr(request, "param", "rostether's master"), tmp_path) as stage:
        yield stage


def texts(inbox: Inbox) -> list[str]:
    return [payload[4:].decode() for payload in inbox.payloads]


@ON_BOTH_MASTERS
async def test_publisher_to_rospy_subscriber(stage: Stage) -> None:
    node = await stage.join("/talker")
    publisher = await node.advertise("/chat", STRING)
    peer = await stage.peers.rospy(SUBSCRIBE, "/chat", "200")
    await until(lambda: publisher.subscriber_count == 1)
    for start in range(0, 200, 50):
        publisher.publish_raw([string(f"message {number}") for number in range(start, start + 50)])
    printed = (await peer.finish()).splitlines()
    assert printed == [f"/talker message {number}" for number in range(200)]
    await until(lambda: publisher.subscriber_count == 0)


@ON_BOTH_MASTERS
@pytest.mark.roscpp
async def test_publisher_to_roscpp_subscriber(stage: Stage) -> None:
    node = await stage.join("/talker")
    publisher = await node.advertise("/chat", STRING)
    peer = await stage.peers.roscpp("listen", "/chat", "200")
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string(f"message {number}") for number in range(200)])
    assert (await peer.finish()).splitlines() == [f"message {number}" for number in range(200)]


@pytest.mark.roscpp
async def test_flood_of_publisher_to_roscpp_any_type_subscriber(stage: Stage) -> None:
    node = await stage.join("/talker")
    publisher = await node.advertise("/chat", STRING)
    count = 100_000
    peer = await stage.peers.roscpp("count", "/chat", str(count), "5")
    await until(lambda: publisher.subscriber_count == 1)
    batch = [string("x" * 60)] * 500
    for _ in range(count // 500):
        if not publisher.publish_raw(batch):
            await publisher.drained(60.0)
    received, size_bytes, *_ = (await peer.finish(60.0)).splitlines()[-1].split()
    assert (int(received), int(size_bytes)) == (count, count * 64)
    assert publisher.dropped_count == 0


@pytest.mark.roscpp
async def test_latched_publisher_to_roscpp_subscriber_and_rostopic_echo(stage: Stage) -> None:
    node = await stage.join("/talker")
    publisher = await node.advertise("/map", STRING, latch=True)
    publisher.publish_raw([string("old"), string("new")])
    peer = await stage.peers.roscpp("listen", "/map", "1")
    assert await peer.finish() == "new"
    assert 'data: "new"' in await stage.peers.run("rostopic", "echo", "-n", "1", "/map")


async def test_publisher_to_rospy_any_type_subscriber(stage: Stage) -> None:
    node = await stage.join("/talker")
    publisher = await node.advertise("/chat", STRING, latch=True)
    publisher.publish_raw([string("anything")])
    peer = await stage.peers.rospy(ECHO_ANY, "/chat")
    assert await peer.finish() == f"std_msgs/String {string('anything').hex()}"


async def test_publisher_refuses_rospy_subscriber_of_another_type(
    stage: Stage, caplog: pytest.LogCaptureFixture
) -> None:
    node = await stage.join("/talker")
    publisher = await node.advertise("/chat", BOOL)
    await stage.peers.rospy(SUBSCRIBE, "/chat", "1")
    await until(lambda: "topic types do not match: [std_msgs/String] vs. [std_msgs/Bool]" in caplog.text)
    assert publisher.subscriber_count == 0


async def test_rospy_publisher_to_subscriber(stage: Stage) -> None:
    node, inbox, late_inbox = await stage.join("/listener"), Inbox(), Inbox()
    await node.subscribe("/chat", STRING, inbox.store, on_connection=inbox.store_header)
    await stage.peers.rospy(PUBLISH, "/chat", "once", "500", "message %d")
    await until(lambda: len(inbox.payloads) == 500)
    assert texts(inbox) == [f"message {number}" for number in range(500)]
    await node.subscribe("/chat", ANY_MESSAGE, late_inbox.store, on_connection=late_inbox.store_header)
    await until(lambda: late_inbox.headers)
    assert late_inbox.headers == inbox.headers
    (header,) = inbox.headers
    assert header["callerid"] == "/py_talker"
    assert (header["type"], header["md5sum"]) == (STRING.name, STRING.md5sum)
    assert header["message_definition"].startswith("string data")


async def test_latched_rospy_publisher_to_subscriber(stage: Stage) -> None:
    peer = await stage.peers.rospy(PUBLISH, "/map", "latch", "3", "map %d")
    await peer.wait_for("sent")
    node, inbox = await stage.join("/listener"), Inbox()
    await node.subscribe("/map", STRING, inbox.store, on_connection=inbox.store_header)
    await until(lambda: inbox.payloads)
    assert texts(inbox) == ["map 2"]
    assert inbox.headers[0]["latching"] == "1"


@pytest.mark.roscpp
async def test_latched_roscpp_publisher_to_subscriber(stage: Stage) -> None:
    node, inbox = await stage.join("/listener"), Inbox()
    await stage.peers.roscpp("latch", "/map", "the map")
    await node.subscribe("/map", STRING, inbox.store, on_connection=inbox.store_header)
    await until(lambda: inbox.payloads)
    assert texts(inbox) == ["the map"]
    assert inbox.headers[0]["latching"] == "1"


@ON_BOTH_MASTERS
@pytest.mark.roscpp
async def test_flood_of_roscpp_publisher_to_subscriber_that_pauses(stage: Stage) -> None:
    node, inbox = await stage.join("/listener"), Inbox()
    subscriber = await node.subscribe("/chat", STRING, inbox.store)
    count = 100_000
    await stage.peers.roscpp("flood", "/chat", str(count), "64", "0")
    await until(lambda: len(inbox.payloads) > 1000)
    subscriber.pause()
    paused_at = len(inbox.payloads)
    # Answers to other nodes show that the event loop runs while nothing is read.
    await node.snapshot()
    assert len(inbox.payloads) == paused_at
    subscriber.resume()
    await until(lambda: len(inbox.payloads) == count)
    assert all(len(payload) == 64 for payload in inbox.payloads)
    numbers = [int(text.split(".")[0].split()[1]) for text in texts(inbox)]
    assert numbers == list(range(count))


async def test_large_message_of_rospy_publisher_to_subscriber(stage: Stage) -> None:
    node, inbox = await stage.join("/listener"), Inbox()
    await node.subscribe("/big", STRING, inbox.store)
    script = PUBLISH.replace("sys.argv[4] % number", "'x' * 20_000_000")
    await stage.peers.rospy(script, "/big", "once", "2", "%")
    await until(lambda: len(inbox.payloads) == 2)
    assert [len(payload) for payload in inbox.payloads] == [20_000_004] * 2


async def test_rospy_publisher_that_restarts_is_found_again(stage: Stage) -> None:
    node, inbox = await stage.join("/listener"), Inbox()
    subscriber = await node.subscribe("/chat", STRING, inbox.store)
    for count in (1, 2):
        peer = await stage.peers.rospy(PUBLISH, "/chat", "once", "1", "hello")
        await until(lambda: len(inbox.payloads) == count)  # noqa: B023 - awaited at once
        await peer.stop()
        await until(lambda: subscriber.publisher_count == 0)


@ON_BOTH_MASTERS
async def test_rostopic_pub_to_subscriber(stage: Stage) -> None:
    node, inbox = await stage.join("/listener"), Inbox()
    await node.subscribe("/chat", STRING, inbox.store)
    await stage.peers.start("rostopic", "pub", "-r", "50", "/chat", "std_msgs/String", "data: hello")
    await until(lambda: len(inbox.payloads) >= 5)
    assert set(texts(inbox)) == {"hello"}


@ON_BOTH_MASTERS
async def test_publisher_to_rostopic_hz_and_bw(stage: Stage) -> None:
    node = await stage.join("/talker")
    publisher = await node.advertise("/chat", STRING)
    rate = await stage.peers.start("rostopic", "hz", "/chat")
    bandwidth = await stage.peers.start("rostopic", "bw", "/chat")
    seen = False
    while not seen:
        publisher.publish_raw([string("tick")])
        await asyncio.sleep(0.02)
        seen = "average rate:" in rate.text and "average:" in bandwidth.text
    assert float(rate.text.partition("average rate:")[2].split()[0]) > 0


async def test_rosbag_records_publisher_and_plays_to_subscriber(stage: Stage, tmp_path: Path) -> None:
    node, inbox = await stage.join("/node"), Inbox()
    publisher = await node.advertise("/chat", STRING)
    bag = tmp_path / "chat.bag"
    recorder = await stage.peers.start("rosbag", "record", "-l", "100", "-O", str(bag), "/chat")
    await until(lambda: publisher.subscriber_count == 1)
    publisher.publish_raw([string(f"message {number}") for number in range(100)])
    await recorder.finish()
    await publisher.close()
    await node.subscribe("/chat", STRING, inbox.store)
    await stage.peers.start("rosbag", "play", "--wait-for-subscribers", str(bag))
    await until(lambda: len(inbox.payloads) == 100)
    assert texts(inbox) == [f"message {number}" for number in range(100)]

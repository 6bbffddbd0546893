"""Nodes as processes at our own master; tests/interop compares them with Debian's rospy."""

from __future__ import annotations

import asyncio
import signal
from pathlib import Path

import pytest

import rostether
from interop.ros1_peers import free_port
from rostether.ros1.master.server import MasterServer
from unit.rospy.programs import line_of, printed, running_script

SCRIPTS = Path(__file__).parents[3] / "interop" / "rospy_scripts"


async def test_a_node_with_its_own_topics_and_services(master: str) -> None:
    arguments = ("chatter:=/talk/other", "_rate:=5", "_name:=karl", "__ns:=/robot", "number:=renamed")
    lines = await printed(SCRIPTS / "node_api.py", *arguments, master_uri=master)
    assert "[('one', 'argument'), ('two', 'argument'), ('three', 'argument')]" in lines
    assert lines[-2:] == ["True", "publish after -> None"]


async def test_a_node_waits_for_its_master() -> None:
    port = free_port()
    script = "import rospy; rospy.init_node('late'); print('here', rospy.get_name())"
    async with running_script(script, master_uri=f"http://127.0.0.1:{port}") as process:
        assert process.stderr is not None
        waiting = await asyncio.wait_for(process.stderr.readline(), 60)
        assert f"Unable to register with master node [http://127.0.0.1:{port}]".encode() in waiting
        server = await MasterServer.start(port=port)
        try:
            assert await line_of(process, "here") == "here /late"
            assert await asyncio.wait_for(process.wait(), 60) == 0
        finally:
            await server.close()


async def test_a_topic_of_another_type_is_a_warning_of_the_node(master: str) -> None:
    script = """
import rospy
from std_msgs.msg import Bool, String
rospy.init_node("mixed")
publisher = rospy.Publisher("/mixed", String, queue_size=1)
subscriber = rospy.Subscriber("/mixed", Bool)
rospy.spin()
"""
    async with running_script(script, master_uri=master) as process:
        assert process.stderr is not None
        line = (await asyncio.wait_for(process.stderr.readline(), 60)).decode()
        assert line.startswith("[WARN] [")
        assert "topic types do not match" in line


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
async def test_a_signal_ends_a_node_that_waits(master: str, number: signal.Signals) -> None:
    script = """
import rospy
from std_srvs.srv import Empty
rospy.init_node("waiting")
rospy.on_shutdown(lambda: print("hook"))
print("ready", flush=True)
try:
    rospy.wait_for_service("missing")
except rospy.ROSInterruptException:
    print("interrupted")
"""
    async with running_script(script, master_uri=master) as process:
        await line_of(process, "ready")
        process.send_signal(number)
        out, err = await asyncio.wait_for(process.communicate(), 60)
        assert out.decode().split() == ["hook", "interrupted"], err.decode()
        assert process.returncode == 0


async def test_a_shutdown_interrupts_a_call(master: str) -> None:
    script = """
import rospy, threading, time
from std_srvs.srv import Empty, EmptyResponse
rospy.init_node("calling")
never = threading.Event()
rospy.Service("slow", Empty, lambda request: never.wait() and EmptyResponse())
threading.Timer(0.3, rospy.signal_shutdown, ["enough"]).start()
try:
    rospy.ServiceProxy("slow", Empty)()
except (rospy.ROSInterruptException, rospy.ServiceException) as error:
    print(type(error).__name__)
"""
    assert (await printed(script, master_uri=master))[0] in ("ROSInterruptException", "ServiceException")


async def test_handlers_can_call_other_services(master: str) -> None:
    script = """
import rospy
from std_srvs.srv import Trigger, TriggerResponse
rospy.init_node("nested")
def handler(depth):
    def handle(request):
        if depth:
            return TriggerResponse(True, "." + rospy.ServiceProxy("s%d" % (depth - 1), Trigger)().message)
        return TriggerResponse(True, "end")
    return handle
for depth in range(12):
    rospy.Service("s%d" % depth, Trigger, handler(depth))
print(rospy.ServiceProxy("s11", Trigger)().message)
"""
    assert await printed(script, master_uri=master) == ["...........end"]


async def test_each_publisher_has_its_own_thread(master: str) -> None:
    script = """
import rospy, threading
from std_msgs.msg import String
rospy.init_node("listener")
both = threading.Barrier(2, timeout=60)
seen = []
def receive(message):
    both.wait()          # passes only when callbacks of both publishers run at once
    seen.append(message.data)
    if len(seen) == 2:
        print(sorted(seen), flush=True)
rospy.Subscriber("/in", String, receive)
print("ready", flush=True)
rospy.spin()
"""
    async with running_script(script, master_uri=master) as process:
        await line_of(process, "ready")
        async with rostether.join("/one", master=master) as one, rostether.join("/two", master=master) as two:
            publishers = [await graph.publisher("/in", "std_msgs/String") for graph in (one, two)]
            for publisher in publishers:
                assert await publisher.wait_for_subscriber(10)
            for name, publisher in zip("ab", publishers, strict=True):
                publisher.publish(data=name)
            assert await line_of(process, "a") == "['a', 'b']"


async def test_a_slow_callback_delays_its_publisher_and_loses_no_message(master: str) -> None:
    script = """
import rospy, time
from std_msgs.msg import Int32
rospy.init_node("slow")
seen = []
def receive(message):
    if not seen:
        time.sleep(0.5)
    seen.append(message.data)
    if len(seen) == 5000:
        print(seen == list(range(5000)), flush=True)
rospy.Subscriber("/in", Int32, receive)
print("ready", flush=True)
rospy.spin()
"""
    async with running_script(script, master_uri=master) as process:
        await line_of(process, "ready")
        async with rostether.join("/fast", master=master) as graph:
            publisher = await graph.publisher("/in", "std_msgs/Int32")
            assert await publisher.wait_for_subscriber(10)
            for number in range(5000):
                if not publisher.publish(data=number):
                    await publisher.drained(1.0)
            assert await line_of(process, "True") == "True"


async def test_simulated_time(master: str) -> None:
    script = """
import rospy
rospy.init_node("simulated")
print("ready", rospy.Time.now(), rospy.rostime.is_wallclock(), flush=True)
rospy.sleep(5)
rate = rospy.Rate(1)
for _ in range(3):
    rate.sleep()
now = rospy.get_time()
print("slept", 107.9 < now < 109.6 or now, flush=True)
try:
    rospy.sleep(1000)
except rospy.exceptions.ROSTimeMovedBackwardsException as error:
    print("back", error.time > 50, flush=True)
"""
    async with rostether.join("/clock_driver", master=master) as graph:
        await graph.set_param("/use_sim_time", True)
        clock = await graph.publisher("/clock", "rosgraph_msgs/Clock")
        async with running_script(script, master_uri=master) as process:
            assert await line_of(process, "ready") == "ready 0 False"
            assert await clock.wait_for_subscriber(10)

            async def drive() -> None:
                for step in range(10_000):
                    ns = (100 * 1_000_000_000) + step * 50_000_000
                    clock.publish(clock={"secs": ns // 1_000_000_000, "nsecs": ns % 1_000_000_000})
                    await asyncio.sleep(0.004)

            driver = asyncio.create_task(drive())
            assert await line_of(process, "slept") == "slept True"
            # It sleeps again before time moves back.
            await asyncio.sleep(1.0)
            driver.cancel()
            await asyncio.wait((driver,))
            clock.publish(clock={"secs": 20, "nsecs": 0})
            assert await line_of(process, "back") == "back True"

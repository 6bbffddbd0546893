from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import rostether.sync
from rostether.errors import (
    MasterUnreachableError,
    SerializationError,
    ServiceCallError,
    ServiceUnavailableError,
)
from rostether.msg.std_msgs import Int32
from rostether.ros1.master.server import MasterServer
from rostether.serde.values import Message
from rostether.srv.std_srvs import SetBool, SetBoolRequest
from rostether.sync.blocking import LOOP

TIMEOUT_S = 60.0


@pytest.fixture(scope="module")
def master() -> Iterator[str]:
    server = LOOP.call(MasterServer.start(port=0))
    yield server.uri
    LOOP.call(server.close())


@pytest.fixture
def talker(master: str) -> Iterator[rostether.sync.Graph]:
    with rostether.sync.join("talker", master=master) as graph:
        yield graph


@pytest.fixture
def listener(master: str) -> Iterator[rostether.sync.Graph]:
    with rostether.sync.join("listener", master=master) as graph:
        yield graph


def test_topics(talker: rostether.sync.Graph, listener: rostether.sync.Graph) -> None:
    chatter = talker.publisher("chatter", "std_msgs/String", latch=True)
    assert chatter.topic == "/chatter"
    chatter.publish("hello")
    assert listener.wait_for_message("chatter", timeout_s=TIMEOUT_S).data == "hello"
    for message in listener.messages("chatter"):
        assert message.data == "hello"
        break
    messages = listener.messages("chatter", "std_msgs/String")
    assert next(messages).data == "hello"
    messages.close()
    messages.close()
    got: queue.Queue[Message] = queue.Queue()
    subscriber = listener.subscriber("chatter", None, got.put)
    assert got.get(timeout=TIMEOUT_S).data == "hello"
    chatter.publish(data="again")
    assert got.get(timeout=TIMEOUT_S).data == "again"
    subscriber.close()
    with pytest.raises(SerializationError, match="dta"):
        chatter.publish(dta=3)
    chatter.close()


def test_threads_share_the_messages_of_a_topic_until_one_ends_them(talker: rostether.sync.Graph) -> None:
    shared = talker.messages("shared", Int32)
    got: queue.Queue[int] = queue.Queue()

    def loop() -> None:
        for message in shared:
            got.put(message.data)

    threads = [threading.Thread(target=loop, daemon=True) for _ in range(2)]
    for thread in threads:
        thread.start()
    numbers = talker.publisher("shared", Int32)
    numbers.wait_for_subscriber()
    for number in range(20):
        numbers.publish(data=number)
    assert sorted(got.get(timeout=TIMEOUT_S) for _ in range(20)) == list(range(20))
    shared.close()
    for thread in threads:
        thread.join(TIMEOUT_S)
        assert not thread.is_alive()
    assert got.empty()


def test_a_subscription_works_after_an_error_of_its_callback(
    talker: rostether.sync.Graph, caplog: pytest.LogCaptureFixture
) -> None:
    got: queue.Queue[int] = queue.Queue()

    def divide(message: Message) -> None:
        got.put(6 // message.data)

    numbers = talker.publisher("numbers", "std_msgs/Int32")
    talker.subscriber("numbers", "std_msgs/Int32", divide)
    assert numbers.wait_for_subscriber(TIMEOUT_S)
    numbers.publish(0)
    numbers.publish(2)
    assert got.get(timeout=TIMEOUT_S) == 3
    assert "the callback divide failed" in caplog.text


def test_services_whose_handlers_use_the_graph(
    talker: rostether.sync.Graph, listener: rostether.sync.Graph
) -> None:
    def enable(request: SetBoolRequest) -> dict[str, Any]:
        if not request.data:
            raise ValueError("cannot be off")
        return {"success": True, "message": str(talker.get_param("/name", "none"))}

    server = talker.service_server("enable", SetBool, enable)
    assert listener.call("enable", SetBool, SetBoolRequest(data=True)).message == "none"
    assert listener.service_client("enable", SetBool).call(data=True).success
    with pytest.raises(ServiceCallError, match="cannot be off"):
        listener.call("enable", "std_srvs/SetBool", {"data": False})
    server.close()


def test_parameters(talker: rostether.sync.Graph) -> None:
    seen: queue.Queue[object] = queue.Queue()
    watch = talker.watch_param("/gain", seen.put)
    assert seen.get(timeout=TIMEOUT_S) is None
    talker.set_param("/gain", 2.5)
    assert seen.get(timeout=TIMEOUT_S) == 2.5
    watch.close()
    assert "/gain" in talker.list_params()
    talker.delete_param("/gain")
    assert not talker.has_param("/gain")


def test_what_a_node_knows(talker: rostether.sync.Graph) -> None:
    talker.loginfo("ready")
    assert talker.node_name == "/talker"
    assert talker.resolve("a") == "/a"
    assert talker.now().secs > 0
    assert "/talker" in talker.snapshot().nodes


def test_types_as_classes(talker: rostether.sync.Graph) -> None:
    numbers = talker.publisher("numbers", Int32, latch=True)
    numbers.publish(data=3)
    assert talker.wait_for_message("numbers", Int32, timeout_s=TIMEOUT_S).data == 3
    for message in talker.messages("numbers", Int32):
        assert message.data.bit_length() == 2
        break
    got: queue.Queue[Int32] = queue.Queue()
    talker.subscriber("numbers", Int32, got.put)
    assert got.get(timeout=TIMEOUT_S).data == 3


def test_no_master() -> None:
    with pytest.raises(MasterUnreachableError):
        rostether.sync.join("talker", master="http://127.0.0.1:9")


def test_a_loop_ends_when_its_node_leaves(master: str) -> None:
    graph = rostether.sync.join("leaver", master=master)
    messages = graph.messages("/never", "std_msgs/String")
    started = threading.Event()

    def leave() -> None:
        started.wait()
        while not graph.snapshot().topics.get("/never"):
            pass
        graph.close()

    thread = threading.Thread(target=leave)
    thread.start()
    started.set()
    assert list(messages) == []
    thread.join()
    graph.close()


@pytest.mark.parametrize("end", ["signal", "exception", "exit"])
def test_a_program_that_ends_leaves_the_graph(master: str, listener: rostether.sync.Graph, end: str) -> None:
    code = (
        "import sys, rostether.sync\n"
        f"graph = rostether.sync.join('short', master={master!r})\n"
        "print('joined', flush=True)\n"
        f"if {end!r} == 'signal':\n    for _ in graph.messages('/never', 'std_msgs/String'): pass\n"
        f"if {end!r} == 'exception': raise KeyError('broken')\n"
    )
    program = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert program.stdout is not None
    assert program.stdout.readline() == b"joined\n"
    if end == "signal":
        os.kill(program.pid, signal.SIGINT)
    _, errors = program.communicate(timeout=TIMEOUT_S)
    assert {"signal": b"KeyboardInterrupt", "exception": b"broken", "exit": b""}[end] in errors
    assert errors.count(b"Traceback") == (end != "exit")
    assert "/short" not in listener.snapshot().nodes


def test_async_callbacks_and_handlers_are_refused(talker: rostether.sync.Graph) -> None:
    nothing: Any = None
    with pytest.raises(TypeError, match="the callback must be a function, not None"):
        talker.subscriber("/chatter", "std_msgs/String", nothing)

    async def receive(_: Message) -> None: ...

    with pytest.raises(TypeError, match="write a plain function"):
        talker.subscriber("/chatter", "std_msgs/String", receive)

    async def switch(_: Message) -> dict[str, bool]:
        return {"success": True}

    with pytest.raises(TypeError, match="the handler is async"):
        talker.service_server("/switch", "std_srvs/SetBool", switch)  # type: ignore[arg-type]


def test_errors_show_the_program_s_frames_only(talker: rostether.sync.Graph) -> None:
    with pytest.raises(ServiceUnavailableError) as raised:
        talker.call("/none", "std_srvs/SetBool", data=True)
    files = {Path(frame.path).name for frame in raised.traceback}
    assert files <= {"test_graph.py", "graph.py", "blocking.py", "loop_thread.py"}

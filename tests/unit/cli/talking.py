"""Nodes that publish to a command under test as soon as it subscribes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from rostether.ros1.node.publication import Publisher
from rostether.ros1.xmlrpc_client import XmlRpcClient
from unit.cli.command_shell import STORE, LiveGraph


def call(graph: LiveGraph, action: Callable[[], object]) -> None:
    """Run a function in the graph's thread."""

    async def work() -> None:
        action()

    graph.do(work())


def in_background(action: Callable[[], object]) -> threading.Thread:
    """Run a function while the command runs."""
    thread = threading.Thread(target=action, daemon=True)
    thread.start()
    return thread


def publish(graph: LiveGraph, topic: str, type_name: str, *messages: dict[str, Any]) -> Publisher:
    """Advertise a topic, and send the messages once it has a subscriber."""
    codec = STORE.codec(type_name)
    node = graph.node(f"talker{topic.replace('/', '_')}")
    publisher = graph.do(node.advertise(topic, STORE.registry.message_type(type_name)))
    payloads = [codec.encode(message) for message in messages]

    def send() -> None:
        # Some commands under test end before they subscribe.
        deadline_s = time.monotonic() + 60
        while publisher.subscriber_count == 0:
            if graph.is_closed or time.monotonic() > deadline_s:
                return
            time.sleep(0.002)
        call(graph, lambda: publisher.publish_raw(payloads))

    in_background(send)
    return publisher


def command_node(graph: LiveGraph) -> str | None:
    """Return the name of the command's node, None before it has registered."""
    names = list(graph.master.api.registrations.nodes)
    return next((name for name in names if name.startswith("/rostopic_")), None)


def shut_down(graph: LiveGraph, name: str) -> None:
    """Shut down a node, as `rosnode kill` does."""

    async def ask() -> None:
        client = XmlRpcClient(graph.master.api.registrations.nodes[name].api)
        await client.call("shutdown", "/test", "user request")
        await client.close()

    graph.do(ask())

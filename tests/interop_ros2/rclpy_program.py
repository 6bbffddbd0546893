"""A ROS 2 node with plain rclpy, without rostether, controlled by JSON lines on its standard input.

Each line is `{"verb": NAME, ...}` and is answered by one line, `{"answer": ...}` or `{"error": ...}`.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import sys
import threading
import time
from typing import Any

from rclpy._rclpy_pybind11 import RCLError
from rclpy.action.client import ActionClient
from rclpy.action.server import ActionServer
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data

TIMEOUT_S = 60.0
QUALITIES = {
    "default": QoSProfile(depth=100),
    "sensor": qos_profile_sensor_data,
    "latched": QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL),
    "rosout": QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL),
}


def find(name: str) -> Any:
    package, kind, short = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), short)


def fill(message: Any, values: dict[str, Any]) -> Any:
    """Set the fields of a message from plain values."""
    for name, value in values.items():
        kind = message.get_fields_and_field_types()[name]
        present = getattr(message, name)
        if isinstance(value, dict):
            fill(present, value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            item = kind.split("[")[0].removeprefix("sequence<").removesuffix(">")
            package, short = item.split("/")
            setattr(message, name, [fill(find(f"{package}/msg/{short}")(), each) for each in value])
        elif kind == "sequence<octet>" or kind.startswith("octet["):
            setattr(message, name, [bytes([each]) for each in value])
        elif kind == "octet":
            setattr(message, name, bytes([value]))
        else:
            setattr(message, name, value)
    return message


def plain(value: Any) -> Any:
    """Return a message, or part of one, in the form of JSON."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bytes):
        return value[0] if len(value) == 1 else list(value)
    if isinstance(value, bool | int | float | str):
        return value
    return [plain(each.item() if hasattr(each, "item") else each) for each in value]


def wait_for(condition: Any, what: str) -> None:
    deadline_s = time.monotonic() + TIMEOUT_S
    while not condition():
        if time.monotonic() > deadline_s:
            raise TimeoutError(what)
        time.sleep(0.005)


class Peer:
    def __init__(self, name: str) -> None:
        self.context = Context()
        self.context.init(args=[])
        self.node = Node(name, context=self.context, namespace="/far", allow_undeclared_parameters=True)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.publishers: dict[str, Any] = {}
        self.received: dict[str, list[Any]] = {}
        self.requests: dict[str, list[Any]] = {}
        self.servers: list[Any] = []
        self.spinning = threading.Thread(target=self.spin, daemon=True)
        self.spinning.start()

    def spin(self) -> None:
        while self.context.ok():
            # An action client may be destroyed while the executor prepares to wait for it.
            with contextlib.suppress(RCLError):
                self.executor.spin_once()

    def close(self) -> None:
        """Leave the graph. The shared memory of DDS that a killed process leaves can block the next
        process.
        """
        self.context.try_shutdown()
        self.spinning.join(5)
        with contextlib.suppress(RCLError):
            self.node.destroy_node()
        self.context.destroy()

    def advertise(self, topic: str, type: str, quality: str = "default") -> None:  # noqa: A002
        self.publishers[topic] = self.node.create_publisher(find(type), topic, QUALITIES[quality])

    def publish(self, topic: str, messages: list[dict[str, Any]], subscribers: int = 1) -> None:
        publisher = self.publishers[topic]
        wait_for(lambda: publisher.get_subscription_count() >= subscribers, f"no subscriber of {topic}")
        for values in messages:
            publisher.publish(fill(publisher.msg_type(), values))

    def unadvertise(self, topic: str) -> None:
        self.node.destroy_publisher(self.publishers.pop(topic))

    def subscribe(
        self,
        topic: str,
        type: str,  # noqa: A002
        quality: str = "default",
        into: str = "",
    ) -> None:
        messages = self.received.setdefault(into or topic, [])
        self.node.create_subscription(find(type), topic, messages.append, QUALITIES[quality])

    def receive(self, topic: str, count: int) -> Any:
        messages = self.received[topic]
        wait_for(lambda: len(messages) >= count, f"{len(messages)} of {count} messages arrived on {topic}")
        return [plain(message) for message in messages]

    def serve(self, service: str, type: str, response: dict[str, Any]) -> None:  # noqa: A002
        requests = self.requests.setdefault(service, [])

        def answer(request: Any, empty: Any) -> Any:
            requests.append(plain(request))
            return fill(empty, response)

        self.node.create_service(find(type), service, answer)

    def received_requests(self, service: str) -> Any:
        return self.requests[service]

    def call(
        self,
        service: str,
        type: str,  # noqa: A002
        request: dict[str, Any],
        timeout_s: float = TIMEOUT_S,
    ) -> Any:
        client: Any = self.node.create_client(find(type), service)
        try:
            if not client.wait_for_service(TIMEOUT_S):
                raise TimeoutError(f"no node offers {service}")
            future = client.call_async(fill(client.srv_type.Request(), request))
            deadline_s = time.monotonic() + timeout_s
            while not future.done():
                if time.monotonic() > deadline_s:
                    return None
                time.sleep(0.001)
            return plain(future.result())
        finally:
            self.node.destroy_client(client)

    def send_goal(self, action: str, type: str, goal: dict[str, Any], cancel: bool = False) -> Any:  # noqa: A002
        """Send a goal, and with `cancel` cancel it after its first feedback; return what was received."""
        client: Any = ActionClient(self.node, find(type), action)
        feedback: list[Any] = []
        try:
            if not client.wait_for_server(TIMEOUT_S):
                raise TimeoutError(f"no node offers {action}")
            sent = client.send_goal_async(
                fill(find(type).Goal(), goal), lambda message: feedback.append(plain(message.feedback))
            )
            wait_for(sent.done, f"{action} does not answer")
            if cancel:
                wait_for(lambda: bool(feedback), f"{action} gives no feedback")
                sent.result().cancel_goal_async()
            ended = sent.result().get_result_async()
            wait_for(ended.done, f"{action} does not end")
            return {
                "feedback": feedback,
                "status": ended.result().status,
                "result": plain(ended.result().result),
            }
        finally:
            client.destroy()

    def serve_action(self, action: str, type: str, result: dict[str, Any]) -> None:  # noqa: A002
        """Serve an action: every goal succeeds with the same result."""
        types: Any = find(type)

        def succeed(goal: Any) -> Any:
            goal.succeed()
            return fill(types.Result(), result)

        self.servers.append(ActionServer(self.node, types, action, succeed))

    def set_own_parameter(self, name: str, value: Any) -> None:
        self.node.set_parameters([Parameter(name, value=value)])

    def get_own_parameter(self, name: str) -> Any:
        return self.node.get_parameter(name).value

    def parameters(self, node: str, method: str, arguments: list[Any]) -> Any:
        client = AsyncParameterClient(self.node, node)
        if not client.wait_for_services(TIMEOUT_S):
            raise TimeoutError(f"{node} does not give access to its parameters")
        if method == "set_parameters":
            arguments = [Parameter(name, value=value) for name, value in arguments]
        future = getattr(client, method)(arguments)
        wait_for(future.done, f"{node} does not answer")
        return plain(future.result())

    def nodes(self) -> Any:
        return self.node.get_node_names_and_namespaces()

    def endpoints(self, topic: str) -> Any:
        return [
            {
                "node": each.node_name,
                "namespace": each.node_namespace,
                "type": each.topic_type,
                "hash": str(each.topic_type_hash),
                "kind": each.endpoint_type.name,
                "reliability": each.qos_profile.reliability.name,
                "durability": each.qos_profile.durability.name,
            }
            for each in (
                *self.node.get_publishers_info_by_topic(topic),
                *self.node.get_subscriptions_info_by_topic(topic),
            )
        ]

    def describe_topic(self, topic: str) -> Any:
        """Return rclpy's description of a topic's endpoints."""
        endpoints = (
            *self.node.get_publishers_info_by_topic(topic),
            *self.node.get_subscriptions_info_by_topic(topic),
        )
        return {each.node_name: str(each) for each in endpoints}

    def endpoints_of_node(self, name: str, namespace: str) -> Any:
        return {
            "publishers": self.node.get_publisher_names_and_types_by_node(name, namespace),
            "subscribers": self.node.get_subscriber_names_and_types_by_node(name, namespace),
            "services": self.node.get_service_names_and_types_by_node(name, namespace),
            "clients": self.node.get_client_names_and_types_by_node(name, namespace),
        }


def main() -> None:
    peer = Peer(sys.argv[1])
    print(json.dumps({"answer": "ready"}), flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        try:
            reply = {"answer": getattr(peer, request.pop("verb"))(**request)}
        except Exception as error:  # noqa: BLE001 - the test gets it
            reply = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(reply), flush=True)
    peer.close()


if __name__ == "__main__":
    main()

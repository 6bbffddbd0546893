"""Uses roslibpy, and prints each check with its result: `roslibpy_client.py PORT twisted|asyncio`."""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Callable
from typing import Any

import roslibpy
import roslibpy.core
from roslibpy.ros1 import actionlib

TIMEOUT_S = 60.0


def report(check: str, found: Any = None) -> None:
    print(json.dumps({"check": check, "found": found}), flush=True)


def next_message(ros: Any, name: str, type_name: str, **options: Any) -> Any:
    """Return the next message of a topic."""
    topic = roslibpy.Topic(ros, name, type_name, **options)
    found: list[Any] = []
    arrived = threading.Event()

    def store(message: Any) -> None:
        found.append(message)
        arrived.set()

    topic.subscribe(store)
    if not arrived.wait(TIMEOUT_S):
        return "no message arrived"
    topic.unsubscribe()
    return dict(found[0])


def failure(call: Callable[[], object]) -> str:
    try:
        return f"no failure: {call()}"
    except roslibpy.core.ServiceException as error:
        return str(error)


def serve_until_called(ros: Any) -> bool:
    service = roslibpy.Service(ros, "/from_program/double", "std_srvs/SetBool")

    def answer(request: Any, response: Any) -> bool:
        response["success"] = not request["data"]
        response["message"] = f"program got {request['data']}"
        return True

    service.advertise(answer)
    report("serving")
    sys.stdin.readline()
    service.unadvertise()
    return True


def publish(ros: Any) -> None:
    twist = roslibpy.Topic(ros, "/from_program", "geometry_msgs/Twist")
    twist.publish(roslibpy.Message({"linear": {"x": 1.5}, "angular": {"z": -0.5}}))
    header = roslibpy.Header(7, roslibpy.Time(5, 6), "map")
    stamped = roslibpy.Topic(ros, "/stamped_from_program", "geometry_msgs/PoseStamped", latch=True)
    stamped.publish(roslibpy.Message({"header": header}))


def action(ros: Any) -> str:
    client = actionlib.ActionClient(ros, "/lookup", "tf2_msgs/LookupTransformAction")
    goal = actionlib.Goal(client, roslibpy.Message({"target_frame": "base", "source_frame": "tool"}))
    goal.send()
    result = goal.wait(TIMEOUT_S)
    client.dispose()
    return str(result["error"]["error_string"])


def wait_for_reconnection(ros: Any) -> Any:
    topic = roslibpy.Topic(ros, "/latched", "std_msgs/String")
    found: list[Any] = []
    arrived = threading.Event()
    closed = threading.Event()
    ros.on("close", lambda _: closed.set())

    def store(message: Any) -> None:
        if closed.is_set():
            found.append(message)
            arrived.set()

    topic.subscribe(store)
    report("waiting for close")
    arrived.wait(TIMEOUT_S)
    return found[-1:] and dict(found[-1])


def main(port: int, transport: str) -> None:
    ros = roslibpy.Ros("127.0.0.1", port, transport=transport)
    ros.run(timeout=TIMEOUT_S)
    enable = roslibpy.Service(ros, "/enable", "std_srvs/SetBool")
    report("latched", next_message(ros, "/latched", "std_msgs/String"))
    report("relative", next_message(ros, "latched", "std_msgs/String"))
    report("nested", next_message(ros, "/pose", "geometry_msgs/PoseStamped"))
    report(
        "throttled", next_message(ros, "/pose", "geometry_msgs/PoseStamped", throttle_rate=50, queue_length=1)
    )
    report("called", dict(enable.call(roslibpy.ServiceRequest({"data": True}), timeout=TIMEOUT_S)))
    fail = roslibpy.Service(ros, "/fail", "std_srvs/Trigger")
    report("refused", failure(lambda: fail.call(roslibpy.ServiceRequest(), timeout=TIMEOUT_S)))
    report("misfit", failure(lambda: enable.call(roslibpy.ServiceRequest({"data": "x"}), timeout=TIMEOUT_S)))
    publish(ros)
    gain = roslibpy.Param(ros, "/program/gain")
    gain.set({"p": 1.5}, timeout=TIMEOUT_S)
    report("parameter", gain.get(timeout=TIMEOUT_S))
    gain.delete(timeout=TIMEOUT_S)
    report("deleted", gain.get(timeout=TIMEOUT_S))
    report("topics", "/pose" in ros.get_topics())
    report("topicType", ros.get_topic_type("/pose"))
    report("topicsForType", ros.get_topics_for_type("geometry_msgs/PoseStamped"))
    report("serviceType", ros.get_service_type("/enable"))
    report("servicesForType", ros.get_services_for_type("std_srvs/SetBool"))
    report("nodes", ros.get_nodes())
    report("nodeDetails", ros.get_node_details("/talker")["services"])
    report("details", ros.get_message_details("geometry_msgs/Twist")["typedefs"][1]["fieldnames"])
    report("time", ros.get_time()["secs"] > 1_600_000_000)
    report("action", action(ros))
    report("served", serve_until_called(ros))
    report("reconnected", wait_for_reconnection(ros))
    ros.terminate()
    # With one of its transports, threads of roslibpy do not end.
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])

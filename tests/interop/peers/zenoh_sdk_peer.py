"""Another implementation of rmw_zenoh's conventions (zenoh-ros2-sdk) in a separate process.

    zenoh_sdk_peer.py PORT DOMAIN

Reads one JSON object per line, executes it, prints {"done": WHAT, ...}. What subscribers get is printed as
it comes: {"got": TOPIC, "fields": {...}}.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from typing import Any

from zenoh_ros2_sdk import ROS2Publisher, ROS2ServiceClient, ROS2ServiceServer, ROS2Subscriber, discovery

ENDS: dict[str, Any] = {}


def say(**fields: Any) -> None:
    print(json.dumps(fields, default=plain), flush=True)


def plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return {
            each.name: getattr(value, each.name)
            for each in dataclasses.fields(value)
            if not each.name.startswith("__")
        }
    return value.tolist()


def build(pub: Any, name: str, value: Any) -> Any:
    """Make a nested message from a mapping; its type is that of the field."""
    if not isinstance(value, dict):
        return value
    store = pub.session_mgr.store
    node = dict(store.get_msgdef(pub.msg_type).fields)[name]
    message_class = store.types[node[1]]
    return message_class(**{key: nested(store, node[1], key, each) for key, each in value.items()})


def nested(store: Any, type_name: str, name: str, value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    node = dict(store.get_msgdef(type_name).fields)[name]
    return store.types[node[1]](**{key: nested(store, node[1], key, each) for key, each in value.items()})


def handle(order: dict[str, Any], place: dict[str, Any]) -> dict[str, Any]:
    what, name = order.pop("do"), order.pop("name", "")
    if what == "advertise":
        ENDS[f"pub {name}"] = ROS2Publisher(topic=name, **order, **place)
    elif what == "publish":
        publisher = ENDS[f"pub {name}"]
        for fields in order["messages"]:
            publisher.publish(**{key: build(publisher, key, each) for key, each in fields.items()})
    elif what == "subscribe":
        ENDS[f"sub {name}"] = ROS2Subscriber(
            topic=name, callback=lambda message: say(got=name, fields=plain(message)), **order, **place
        )
    elif what == "serve":
        prefix = order.pop("answer")

        def answer(request: Any) -> Any:
            response = ENDS[f"srv {name}"].response_msg_class
            return response(success=request.data, message=prefix + str(request.data))

        ENDS[f"srv {name}"] = ROS2ServiceServer(service_name=name, callback=answer, **order, **place)
    elif what == "call":
        fields = order.pop("request")
        client = ROS2ServiceClient(service_name=name, **order, **place)
        try:
            response = client.call(**fields)
            return {"response": None if response is None else plain(response)}
        finally:
            client.close()
    elif what == "topics":
        found = discovery.get_topic_names_and_types(timeout=2.0, **place)
        return {"topics": dict(found)}
    elif what == "topic":
        info = discovery.get_topic_info(name, timeout=2.0, verbose=True, **place)
        return {"info": None if info is None else plain(info)}
    elif what == "close":
        ENDS.pop(name).close()
    return {}


def main(port: str, domain: str) -> None:
    place = {"router_port": int(port), "domain_id": int(domain)}
    say(done="start")
    for line in sys.stdin:
        order = json.loads(line)
        what = order["do"]
        try:
            say(done=what, **handle(order, place))
        except Exception as error:  # noqa: BLE001 - the test is to see it
            say(done=what, error=repr(error))


main(*sys.argv[1:])

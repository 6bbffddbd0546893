"""Another implementation of rmw_zenoh's conventions (zenoh-ros2-sdk) in a separate process.

    zenoh_sdk_peer.py PORT DOMAIN

Reads one JSON object per line, executes it, prints {"done": VERB, ...}. Messages of subscriptions are printed
when they arrive: {"received": TOPIC, "fields": {...}}.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from typing import Any

from zenoh_ros2_sdk import ROS2Publisher, ROS2ServiceClient, ROS2ServiceServer, ROS2Subscriber, discovery

ENDPOINTS: dict[str, Any] = {}


def report(**fields: Any) -> None:
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


def handle(command: dict[str, Any], connection: dict[str, Any]) -> dict[str, Any]:
    verb, name = command.pop("do"), command.pop("name", "")
    if verb == "advertise":
        ENDPOINTS[f"pub {name}"] = ROS2Publisher(topic=name, **command, **connection)
    elif verb == "publish":
        publisher = ENDPOINTS[f"pub {name}"]
        for fields in command["messages"]:
            publisher.publish(**{key: build(publisher, key, each) for key, each in fields.items()})
    elif verb == "subscribe":
        ENDPOINTS[f"sub {name}"] = ROS2Subscriber(
            topic=name,
            callback=lambda message: report(received=name, fields=plain(message)),
            **command,
            **connection,
        )
    elif verb == "serve":
        prefix = command.pop("answer")

        def answer(request: Any) -> Any:
            response = ENDPOINTS[f"srv {name}"].response_msg_class
            return response(success=request.data, message=prefix + str(request.data))

        ENDPOINTS[f"srv {name}"] = ROS2ServiceServer(
            service_name=name, callback=answer, **command, **connection
        )
    elif verb == "call":
        fields = command.pop("request")
        client = ROS2ServiceClient(service_name=name, **command, **connection)
        try:
            response = client.call(**fields)
            return {"response": None if response is None else plain(response)}
        finally:
            client.close()
    elif verb == "topics":
        found = discovery.get_topic_names_and_types(timeout=2.0, **connection)
        return {"topics": dict(found)}
    elif verb == "topic":
        info = discovery.get_topic_info(name, timeout=2.0, verbose=True, **connection)
        return {"info": None if info is None else plain(info)}
    elif verb == "close":
        ENDPOINTS.pop(name).close()
    return {}


def main(port: str, domain: str) -> None:
    connection = {"router_port": int(port), "domain_id": int(domain)}
    report(done="start")
    for line in sys.stdin:
        command = json.loads(line)
        verb = command["do"]
        try:
            report(done=verb, **handle(command, connection))
        except Exception as error:  # noqa: BLE001 - the test reports it
            report(done=verb, error=repr(error))


main(*sys.argv[1:])

"""The master under random registrations: its tables agree with each other, and every node has the current
state.
"""

from __future__ import annotations

from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from effort import effort
from rostether.ros1.master.master_api import MasterApi
from rostether.ros1.master.registrations import EntryKind
from rostether.xmlrpc.document_writer import dump_response
from rostether.xmlrpc.values import XmlRpcValue
from xmlrpc_documents import load_response

NODES = st.sampled_from(["/a", "/b", "/ns/c"])
INSTANCES = st.sampled_from([1, 2])
TOPICS = st.sampled_from(["/t", "t", "~t"])
SERVICES = st.sampled_from(["/s", "~s"])
TYPES = st.sampled_from(["*", "std_msgs/String", "std_msgs/Int32"])
ARGUMENTS = st.sampled_from(["", "/", "a b", "http://x:1", "/t", "~"]) | st.integers(0, 3) | st.none()


def api_of(node: str, instance: int) -> str:
    return f"http://host{node.replace('/', '-')}:{instance}/"


class Nodes:
    """What each node knows from the master's answers and calls."""

    def __init__(self) -> None:
        self.publishers: dict[tuple[str, str], list[str]] = {}
        self.stopped: set[str] = set()

    def publisher_update(self, api: str, topic: str, publishers: list[str]) -> None:
        self.publishers[api, topic] = publishers

    def param_update(self, api: str, key: str, value: XmlRpcValue) -> None:
        raise AssertionError("no parameter is watched here")

    def ping(self, api: str) -> None:
        self.stopped.discard(api)

    def shut_down(self, api: str, reason: str) -> None:
        self.stopped.add(api)


class MasterUnderRegistrations(RuleBasedStateMachine):
    """Nodes join, leave, are replaced by a node with the same name, and are killed."""

    def __init__(self) -> None:
        super().__init__()
        self.nodes = Nodes()
        self.api = MasterApi(self.nodes, print)
        self.methods = self.api.dispatch()
        # {(kind, key): {node: api}}, updated in the simplest way.
        self.model: dict[tuple[EntryKind, str], dict[str, str]] = {}

    def call(self, method: str, *args: Any) -> Any:
        answer = self.methods[method](*args)
        decoded = load_response(dump_response(answer))
        assert isinstance(decoded, list)
        return decoded[2]

    def expect(self, kind: EntryKind, key: str, node: str, api: str, *, replaces: bool = False) -> None:
        for members in self.model.values():
            if members.get(node, api) != api:
                del members[node]
        members = self.model.setdefault((kind, key), {})
        if replaces:
            members.clear()
        members[node] = api

    def expect_removed(self, kind: EntryKind, key: str, node: str, api: str) -> int:
        members = self.model.get((kind, key), {})
        if members.get(node) != api:
            return 0
        del members[node]
        return 1

    @staticmethod
    def resolve(name: str, node: str) -> str:
        if name.startswith("/"):
            return name
        return f"{node}/{name[1:]}" if name.startswith("~") else f"{node.rpartition('/')[0]}/{name}"

    @rule(node=NODES, instance=INSTANCES, topic=TOPICS, type_name=TYPES)
    def register_publisher(self, node: str, instance: int, topic: str, type_name: str) -> None:
        api = api_of(node, instance)
        answer = self.call("registerPublisher", node, topic, type_name, api)
        self.expect(EntryKind.PUBLISHER, self.resolve(topic, node), node, api)
        subscribers = self.model.get((EntryKind.SUBSCRIBER, self.resolve(topic, node)), {})
        assert answer == list(subscribers.values())

    @rule(node=NODES, instance=INSTANCES, topic=TOPICS, type_name=TYPES)
    def register_subscriber(self, node: str, instance: int, topic: str, type_name: str) -> None:
        api, name = api_of(node, instance), self.resolve(topic, node)
        self.nodes.publishers[api, name] = self.call("registerSubscriber", node, topic, type_name, api)
        self.expect(EntryKind.SUBSCRIBER, name, node, api)

    @rule(node=NODES, instance=INSTANCES, service=SERVICES)
    def register_service(self, node: str, instance: int, service: str) -> None:
        api = api_of(node, instance)
        self.call("registerService", node, service, f"rosrpc://{node}:{instance}", api)
        self.expect(EntryKind.SERVICE, self.resolve(service, node), node, api, replaces=True)

    @rule(node=NODES, instance=INSTANCES, topic=TOPICS)
    def unregister_publisher(self, node: str, instance: int, topic: str) -> None:
        api = api_of(node, instance)
        removed = self.expect_removed(EntryKind.PUBLISHER, self.resolve(topic, node), node, api)
        assert self.call("unregisterPublisher", node, topic, api) == removed

    @rule(node=NODES, instance=INSTANCES, topic=TOPICS)
    def unregister_subscriber(self, node: str, instance: int, topic: str) -> None:
        api = api_of(node, instance)
        removed = self.expect_removed(EntryKind.SUBSCRIBER, self.resolve(topic, node), node, api)
        assert self.call("unregisterSubscriber", node, topic, api) == removed

    @rule(node=NODES, instance=INSTANCES, service=SERVICES)
    def unregister_service(self, node: str, instance: int, service: str) -> None:
        name = self.resolve(service, node)
        removed = self.expect_removed(EntryKind.SERVICE, name, node, api_of(node, instance))
        assert self.call("unregisterService", node, service, f"rosrpc://{node}:{instance}") == removed

    @rule(node=NODES)
    def end_node(self, node: str) -> None:
        self.api.drop_node(node)
        for members in self.model.values():
            members.pop(node, None)

    @rule(data=st.data(), args=st.lists(ARGUMENTS, max_size=5))
    def call_with_an_invalid_caller(self, data: st.DataObject, args: list[Any]) -> None:
        # Only calls that cannot succeed: the caller's name is invalid.
        method = data.draw(st.sampled_from(sorted(self.methods)))
        code, text, _ = answer = self.methods[method](7, *args)
        dump_response(answer)
        assert code == -1
        assert text

    @invariant()
    def the_state_equals_the_model(self) -> None:
        state = self.call("getSystemState", "/x")
        for kind, table in zip(
            (EntryKind.PUBLISHER, EntryKind.SUBSCRIBER, EntryKind.SERVICE),
            state,
            strict=True,
        ):
            expected = {
                key: sorted(members)
                for (each, key), members in self.model.items()
                if each is kind and members
            }
            assert {key: sorted(members) for key, members in table} == expected

    @invariant()
    def tables_agree(self) -> None:
        tables = self.api.registrations
        keys = {(kind, key) for kind in EntryKind for key in tables.keys(kind)}
        assert tables._count == sum(len(tables.members(*each)) for each in keys)
        for kind, key in keys:
            for name, api in tables.members(kind, key).items():
                assert tables.nodes[name].api == api
                assert key in tables.nodes[name].keys[kind]
                assert api not in self.nodes.stopped
        for name, node in tables.nodes.items():
            assert not node.is_empty
            for kind in (EntryKind.PUBLISHER, EntryKind.SUBSCRIBER, EntryKind.PARAM):
                assert all(name in tables.members(kind, key) for key in node.keys[kind])
        for service in tables.keys(EntryKind.SERVICE):
            (name,) = tables.members(EntryKind.SERVICE, service)
            assert str(tables.service_api(service)).startswith(f"rosrpc://{name}:")
        assert set(tables._service_apis) == set(tables.keys(EntryKind.SERVICE))
        assert set(tables.keys(EntryKind.PUBLISHER)) <= set(tables.topic_types)

    @invariant()
    def every_subscriber_has_the_current_publishers(self) -> None:
        tables = self.api.registrations
        for topic in tables.keys(EntryKind.SUBSCRIBER):
            for api in tables.apis(EntryKind.SUBSCRIBER, topic):
                assert self.nodes.publishers[api, topic] == tables.apis(EntryKind.PUBLISHER, topic)


TestMasterUnderRegistrations = MasterUnderRegistrations.TestCase
TestMasterUnderRegistrations.settings = settings(
    max_examples=effort(40, 120), stateful_step_count=40, deadline=None
)

"""The Master API without a network: its answers, and its calls to nodes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rostether.errors import SerializationError
from rostether.ros1.master.master_api import MasterApi
from rostether.xmlrpc.document_writer import dump_response
from rostether.xmlrpc.values import XmlRpcValue

A, B = "http://a:1/", "http://b:2/"


class RecordedCalls:
    """Records every call to a node."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self.pinged: list[str] = []

    def publisher_update(self, api: str, topic: str, publishers: list[str]) -> None:
        self.calls.append((api, topic, publishers))

    def param_update(self, api: str, key: str, value: XmlRpcValue) -> None:
        self.calls.append((api, key, value))

    def ping(self, api: str) -> None:
        self.pinged.append(api)

    def shut_down(self, api: str, reason: str) -> None:
        self.calls.append((api, "shutdown", reason))

    def take(self) -> list[tuple[Any, ...]]:
        calls, self.calls = self.calls, []
        return calls


class Master:
    """The API with its calls by name."""

    def __init__(self) -> None:
        self.reported = RecordedCalls()
        self.stops: list[str] = []
        self.api = MasterApi(self.reported, self.stops.append)
        self.api.uri = "http://master:11311/"
        self._methods: dict[str, Callable[..., Any]] = self.api.dispatch()

    def call(self, method: str, *args: Any) -> Any:
        code, text, value = self._methods[method](*args)
        return code, text, as_sent(value)


def as_sent(value: Any) -> Any:
    """Return a value as it is sent: iterators become arrays, without None."""
    if isinstance(value, (list, tuple, Iterator)):
        return [as_sent(item) for item in value if item is not None]
    return value


@pytest.fixture
def master() -> Master:
    return Master()


def test_identity(master: Master) -> None:
    assert master.call("getUri", "/x") == (1, "", "http://master:11311/")
    assert master.call("getPid", "/x") == (1, "", os.getpid())


@pytest.mark.parametrize("method", list(MasterApi(RecordedCalls(), print).dispatch()))
def test_every_method_refuses_bad_calls_with_a_triplet(master: Master, method: str) -> None:
    for args in ([], [5], ["/x", *["y"] * 7], [[], 1, 2, 3]):
        code, text, value = master.call(method, *args)
        assert code == -1
        assert text
        dump_response((code, text, value))


def test_topics(master: Master) -> None:
    assert master.call("registerSubscriber", "/s", "t", "*", B) == (1, "Subscribed to [/t]", [])
    registered = master.call("registerPublisher", "/p", "/t", "std_msgs/String", A)
    assert registered == (1, "Registered [/p] as publisher of [/t]", [B])
    assert master.reported.take() == [(B, "/t", [A])]
    assert master.call("registerSubscriber", "/p", "/t", "std_msgs/String", A)[2] == [A]
    assert master.call("getPublishedTopics", "/x", "")[2] == [["/t", "std_msgs/String"]]
    assert master.call("getPublishedTopics", "/x", "/ns")[2] == []
    assert master.call("getTopicTypes", "/x")[2] == [["/t", "std_msgs/String"]]
    assert master.call("getSystemState", "/x")[2] == [[["/t", ["/p"]]], [["/t", ["/s", "/p"]]], []]
    assert master.call("lookupNode", "/x", "/p") == (1, "node api", A)
    assert master.call("unregisterPublisher", "/p", "/t", A)[2] == 1
    assert master.reported.take() == [(B, "/t", []), (A, "/t", [])]
    assert master.call("unregisterPublisher", "/p", "/t", A)[2] == 0
    assert master.reported.take() == []
    assert master.call("unregisterSubscriber", "/s", "/t", B)[2] == 1
    assert master.call("unregisterSubscriber", "/s", "/t", B) == (1, "[/s] is not a registered node", 0)
    assert master.call("lookupNode", "/x", "/s") == (-1, "unknown node [/s]", "")


def test_services(master: Master) -> None:
    assert master.call("registerService", "/p", "~s", "rosrpc://a:5", A)[2] == 1
    assert master.call("lookupService", "/x", "/p/s")[2] == "rosrpc://a:5"
    assert master.call("unregisterService", "/p", "/p/s", "rosrpc://other:1")[2] == 0
    assert master.call("unregisterService", "/p", "/p/s", "rosrpc://a:5")[2] == 1
    assert master.call("lookupService", "/x", "/p/s") == (-1, "no provider", "")


def test_a_replaced_node_is_shut_down_and_its_subscribers_are_informed(master: Master) -> None:
    master.call("registerPublisher", "/p", "/t", "std_msgs/String", A)
    master.call("registerSubscriber", "/s", "/t", "std_msgs/String", B)
    new = "http://a:99/"
    master.call("registerPublisher", "/p", "/u", "std_msgs/String", new)
    assert master.reported.take() == [
        (A, "shutdown", "[/p] Reason: new node registered with same name"),
        (B, "/t", []),
    ]
    assert master.reported.pinged == [A, B, new], "each node is checked from its first registration on"


def test_a_node_that_has_ended_is_removed_with_its_registrations(master: Master) -> None:
    master.call("registerPublisher", "/p", "/t", "std_msgs/String", A)
    master.call("registerService", "/p", "/s", "rosrpc://a:5", A)
    master.call("registerSubscriber", "/s", "/t", "std_msgs/String", B)
    master.reported.take()
    master.api.drop_node("/p")
    master.api.drop_node("/p")
    assert master.reported.take() == [(B, "/t", [])]
    assert master.call("getSystemState", "/x")[2] == [[], [["/t", ["/s"]]], []]


def test_parameters(master: Master) -> None:
    assert master.call("setParam", "/ns/n", "~a", 5) == (1, "parameter /ns/n/a set", 0)
    assert master.call("setParam", "/ns/n", "b", {"c": "x"})[0] == 1
    assert master.call("getParam", "/x", "/ns") == (1, "Parameter [/ns]", {"n": {"a": 5}, "b": {"c": "x"}})
    assert master.call("getParam", "/x", "/none") == (-1, "Parameter [/none] is not set", 0)
    assert master.call("hasParam", "/ns/n", "b/c") == (1, "/ns/b/c", True)
    assert master.call("searchParam", "/ns/n/deep", "b")[2] == "/ns/b"
    assert master.call("searchParam", "/ns", "none")[0] == -1
    assert master.call("searchParam", "/ns", "~b")[0] == 0
    assert master.call("searchParam", "ns", "b")[0] == 0
    assert master.call("getParamNames", "/x")[2] == ["/ns/n/a", "/ns/b/c"]
    assert master.call("deleteParam", "/x", "/ns/b") == (1, "parameter /ns/b deleted", 0)
    assert master.call("deleteParam", "/x", "/ns/b") == (-1, "parameter [/ns/b] is not set", 0)
    assert master.call("setParam", "/x", "/", 5)[0] == -1
    assert master.call("setParam", "/x", "/a", None) == (-1, "ERROR: parameter [value] must be specified", 0)


def test_watchers_of_a_parameter(master: Master) -> None:
    assert master.call("subscribeParam", "/p", A, "/a") == (1, "Subscribed to parameter [/a]", {})
    assert master.call("subscribeParam", "/s", B, "/a/b")[2] == {}
    master.call("setParam", "/x", "/a", {"b": 1})
    assert master.reported.take() == [(B, "/a/b/", 1), (A, "/a/", {"b": 1})]
    assert master.call("subscribeParam", "/p", A, "/a")[2] == {"b": 1}
    master.call("setParam", "/p", "/a/b", 2)
    assert master.reported.take() == [(B, "/a/b/", 2)], "the node that sets a value gets no update"
    master.call("deleteParam", "/p", "/a")
    assert master.reported.take() == [(B, "/a/b/", {}), (A, "/a/", {})]
    assert master.call("unsubscribeParam", "/p", A, "/a/") == (1, "Unsubscribe to parameter [/a]", 1)
    master.call("setParam", "/x", "/a", 7)
    assert master.reported.take() == [(B, "/a/b/", {})], "only the remaining watcher gets an update"


def test_watching_alone_makes_a_node(master: Master) -> None:
    master.call("subscribeParam", "/p", A, "/a")
    assert master.call("lookupNode", "/x", "/p")[2] == A
    master.call("unsubscribeParam", "/p", A, "/a")
    assert master.call("lookupNode", "/x", "/p")[0] == -1


def test_shutdown_is_passed_on(master: Master) -> None:
    assert master.call("shutdown", "/x", "enough") == (1, "shutdown", 0)
    assert master.stops == ["shutdown request from /x: 'enough'"]


def test_every_answer_can_be_sent(master: Master) -> None:
    master.call("setParam", "/x", "/a", [1, {"b": b"\x00"}])
    for method in ("getParamNames", "getSystemState", "getTopicTypes", "getUri", "getPid"):
        dump_response(master.call(method, "/x"))
    with pytest.raises(SerializationError):
        dump_response(2**40)

"""The names, types and URIs that the Master API accepts."""

from __future__ import annotations

import pytest

from rostether.ros1.master.argument_checks import (
    MAX_NAME_LENGTH,
    BadArgumentError,
    Check,
    any_value,
    api_of,
    name_of,
    param_key,
    resolve,
    some_value,
    subgraph,
    topic_type,
)
from rostether.xmlrpc.values import XmlRpcValue


@pytest.mark.parametrize(
    ("name", "caller", "resolved"),
    [
        ("/a", "/ns/node", "/a"),
        ("a", "/ns/node", "/ns/a"),
        ("a/b", "/node", "/a/b"),
        ("~a", "/ns/node", "/ns/node/a"),
        ("~", "/ns/node", "/ns/node"),
        ("", "/ns/node", "/ns/"),
        ("//a//b/", "/x", "/a/b"),
        ("a", "relative", "/a"),
        ("/", "/x", "/"),
        ("a", "/", "/a"),
    ],
)
def test_names_resolve_against_the_caller(name: str, caller: str, resolved: str) -> None:
    assert resolve(name, caller) == resolved


topic = name_of("topic", may_be_root=False)


@pytest.mark.parametrize(
    ("check", "value", "result"),
    [
        (any_value, None, None),
        (some_value, 0, 0),
        (param_key, "~x", "~x"),
        (topic, "t-with-dashes", "/ns/t-with-dashes"),
        (name_of("node"), "/", "/"),
        (subgraph, "", ""),
        (subgraph, "sub", "/ns/sub"),
        (topic_type, "*", "*"),
        (topic_type, "std_msgs/String", "std_msgs/String"),
        (api_of("caller_api"), "http://x:1/", "http://x:1/"),
        (api_of("service_api"), "rosrpc://x:1", "rosrpc://x:1"),
    ],
)
def test_what_passes(check: Check, value: XmlRpcValue, result: XmlRpcValue) -> None:
    assert check(value, "/ns/node") == result


@pytest.mark.parametrize(
    ("check", "value", "reason"),
    [
        (some_value, None, "value.* must be specified"),
        (param_key, "", "key.* non-empty"),
        (param_key, 5, "key.* must be a string"),
        (param_key, "x" * (MAX_NAME_LENGTH + 1), "at most"),
        (topic, "", "topic.* non-empty string"),
        (topic, ["t"], "topic.* non-empty string"),
        (topic, "a b", "illegal chars"),
        (topic, "http://x", "illegal chars"),
        (topic, "/a\x9b2J", "illegal chars"),
        (topic, "/a\nFAKE", "illegal chars"),
        (param_key, "/a\u202e", "illegal chars"),
        (api_of("caller_api"), "http://x:1/\n", "not an RPC URI"),
        (topic, "/", "cannot be the global namespace"),
        (topic, "x" * (MAX_NAME_LENGTH + 1), "longer than"),
        (subgraph, 5, "must be a string"),
        (topic_type, "String", "not a valid package resource name"),
        (topic_type, "a/b/c", "not a valid package resource name"),
        (topic_type, "", "non-empty"),
        (api_of("caller_api"), "", "caller_api.* not an XMLRPC URI"),
        (api_of("caller_api"), 5, "not an XMLRPC URI"),
        (api_of("caller_api"), "ftp://x", "not an RPC URI"),
        (api_of("caller_api"), "http://" + "x" * MAX_NAME_LENGTH, "not an XMLRPC URI"),
    ],
)
def test_what_does_not(check: Check, value: XmlRpcValue, reason: str) -> None:
    with pytest.raises(BadArgumentError, match=reason):
        check(value, "/ns/node")

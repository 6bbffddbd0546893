"""Names resolve and remap as in Debian's rosgraph.names."""

from __future__ import annotations

import itertools
import json
import subprocess
from typing import Any

import pytest

from rostether.errors import ConfigError, InvalidNameError
from rostether.names.graph_name import canonical, is_legal_name, join, namespace_of, resolve_name
from rostether.names.remap import parse_arguments

pytestmark = pytest.mark.ros1

ROSGRAPH_REFERENCE = """
import json, sys
import rosgraph.names as names
request = json.load(sys.stdin)
json.dump({
    "legal": {name: bool(names.is_legal_name(name)) for name in request["names"]},
    "canonical": {name: names.canonicalize_name(name) for name in request["names"]},
    "namespace": {name: names.namespace(name) for name in request["names"]},
    "join": {name: [names.ns_join(ns, name) for ns in request["namespaces"]] for name in request["names"]},
    "resolve": {name: names.resolve_name(name, request["node"], request["remappings"])
                for name in request["names"]},
    "mappings": names.load_mappings(request["argv"]),
}, sys.stdout)
"""
NAMES = sorted({"".join(parts) for length in range(5) for parts in itertools.product("/~a1_", repeat=length)})
NAMESPACES = ["", "/", "/ns", "/ns/", "~", "ns"]
NODE = "/a/node"
REMAPPINGS = {"/a": "/x", "/a/a": "/y", "/a/node/a": "/z", "/a/_": "/never_legal"}
ARGV = ["a:=b", "/a:=~b", "~a:=/b", "_a:=1", "__name:=n", "__ns:=/ns", "x", "a/b:= c ", "--x=1", "d:=", ":=e"]


def reference() -> Any:
    request = {
        "names": NAMES,
        "namespaces": NAMESPACES,
        "node": NODE,
        "remappings": REMAPPINGS,
        "argv": ARGV,
    }
    completed = subprocess.run(
        ["/usr/bin/python3", "-c", ROSGRAPH_REFERENCE],
        input=json.dumps(request).encode(),
        capture_output=True,
        timeout=60,
    )
    assert completed.returncode == 0, completed.stderr.decode()
    return json.loads(completed.stdout)


def test_names_are_legal_join_and_resolve_as_in_rosgraph() -> None:
    expected = reference()
    assert {name: is_legal_name(name) for name in NAMES} == expected["legal"]
    for name in NAMES:
        if not is_legal_name(name):
            continue
        assert canonical(name) == expected["canonical"][name], name
        # rosgraph's namespaces end with a slash.
        assert canonical(namespace_of(name)) == (canonical(expected["namespace"][name]) or "/"), name
        assert [join(namespace, name) for namespace in NAMESPACES] == expected["join"][name], name
        resolved = resolve_name(name, namespace="/a", node_name=NODE, remappings=REMAPPINGS)
        # For the empty name rosgraph gives '/a/', which it does not remap.
        assert resolved == expected["resolve"][name] or not name, name


def test_illegal_names_do_not_resolve() -> None:
    for name in NAMES:
        if not is_legal_name(name) and not is_legal_name(canonical(name)):
            with pytest.raises(InvalidNameError):
                resolve_name(name, namespace="/a", node_name=NODE)


def test_remappings_are_found_as_in_rosgraph() -> None:
    parsed = parse_arguments(ARGV)
    assert {**parsed.remappings, **parsed.special} == reference()["mappings"]
    assert parsed.private_params == {"a": 1}
    with pytest.raises(ConfigError):
        parse_arguments(["a:=b:=c"])

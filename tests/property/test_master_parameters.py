"""The parameter server under random changes: every watcher has the current values, and the size is
correct.
"""

from __future__ import annotations

import copy
from copy import deepcopy
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from effort import effort
from rostether.ros1.master.master_api import MasterApi
from rostether.ros1.master.parameter_tree import _BYTES_PER_VALUE, ParameterTree, watch_key
from rostether.xmlrpc.values import XmlRpcValue

PARTS = st.sampled_from(["a", "b", "c"])
NAMES = st.lists(PARTS, max_size=3).map(lambda parts: "/" + "/".join(parts))
LEAVES = (
    st.integers(0, 9) | st.text("xy", max_size=3) | st.lists(st.integers(0, 3), max_size=2) | st.booleans()
)
VALUES: st.SearchStrategy[Any] = st.recursive(
    LEAVES, lambda inner: st.dictionaries(PARTS, inner, max_size=3), max_leaves=5
)
WATCHERS = st.sampled_from(["/w1", "/w2"])


def without_empty(value: Any) -> Any:
    """Return a tree without empty namespaces, which are the same as unset parameters."""
    if not isinstance(value, dict):
        return value
    inner = {key: without_empty(item) for key, item in value.items()}
    return {key: item for key, item in inner.items() if item != {}}


def read(tree: ParameterTree, name: str) -> Any:
    return without_empty(tree.get(name)) if tree.has(name) else {}


def weight(value: Any) -> int:
    if isinstance(value, dict):
        return _BYTES_PER_VALUE + sum(len(key) + weight(item) for key, item in value.items())
    if isinstance(value, list):
        return _BYTES_PER_VALUE + sum(weight(item) for item in value)
    return _BYTES_PER_VALUE + (len(value) if isinstance(value, str) else 0)


class Watchers:
    """Each watcher's copy of its parameters, from its updates."""

    def __init__(self) -> None:
        self.views: dict[str, ParameterTree] = {}

    def publisher_update(self, api: str, topic: str, publishers: list[str]) -> None:
        raise AssertionError("no topics here")

    def param_update(self, api: str, key: str, value: XmlRpcValue) -> None:
        self.views.setdefault(api, ParameterTree()).set(key, copy.deepcopy(value))

    def ping(self, api: str) -> None:
        assert api

    def shut_down(self, api: str, reason: str) -> None:
        raise AssertionError("no node is replaced here")


class MasterUnderChanges(RuleBasedStateMachine):
    """One node sets and deletes parameters; others watch them at any level."""

    def __init__(self) -> None:
        super().__init__()
        self.watchers = Watchers()
        self.api = MasterApi(self.watchers, print)
        self.methods = self.api.dispatch()
        self.watched: set[tuple[str, str]] = set()

    @property
    def tree(self) -> ParameterTree:
        return self.api.parameters

    @rule(name=NAMES, value=VALUES)
    def set(self, name: str, value: Any) -> None:
        before = deepcopy(self.tree.get("/"))
        code, _, _ = self.methods["setParam"]("/setter", name, copy.deepcopy(value))
        if code == 1:
            assert self.tree.get(name) == value
        else:
            assert name == "/"
            assert not isinstance(value, dict)
            assert self.tree.get("/") == before

    @rule(name=NAMES)
    def delete(self, name: str) -> None:
        existed = name != "/" and self.tree.has(name)
        code, _, _ = self.methods["deleteParam"]("/setter", name)
        assert code == (1 if existed else -1)
        assert not self.tree.has(name) or name == "/"

    @rule(name=NAMES, watcher=WATCHERS)
    def watch(self, name: str, watcher: str) -> None:
        api = f"http:/{watcher}/"
        _, _, value = self.methods["subscribeParam"](watcher, api, name)
        # `{}` means unset, which changes nothing for a watcher whose parent has a plain value.
        view = self.watchers.views.setdefault(api, ParameterTree())
        if value != {} or view.has(name):
            self.watchers.param_update(api, watch_key(name), value)
        self.watched.add((api, name))

    @rule(name=NAMES, watcher=WATCHERS)
    def unwatch(self, name: str, watcher: str) -> None:
        api = f"http:/{watcher}/"
        self.methods["unsubscribeParam"](watcher, api, name)
        self.watched.discard((api, name))

    @rule(namespace=NAMES, first=PARTS, rest=st.sampled_from(["", "/a", "/none"]))
    def search(self, namespace: str, first: str, rest: str) -> None:
        code, _, found = self.methods["searchParam"](namespace, first + rest)
        namespaces = [namespace]
        while namespaces[-1] != "/":
            namespaces.append(namespaces[-1].rpartition("/")[0] or "/")
        matches = [each for each in namespaces if self.tree.has(f"{each}/{first}")]
        assert code == (1 if matches else -1)
        assert found == (f"{matches[0].rstrip('/')}/{first}{rest}" if matches else "")

    @invariant()
    def every_watcher_has_the_current_values(self) -> None:
        for api, name in self.watched:
            assert read(self.watchers.views[api], name) == read(self.tree, name), (api, name)

    @invariant()
    def names_are_the_leaves(self) -> None:
        names = [name for name in self.tree.names() if name]
        assert len(set(names)) == len(names)
        for name in names:
            assert not isinstance(self.tree.get(name), dict)

    @invariant()
    def the_size_is_correct(self) -> None:
        assert self.tree._bytes == weight(self.tree.get("/"))


TestMasterUnderChanges = MasterUnderChanges.TestCase
TestMasterUnderChanges.settings = settings(max_examples=effort(30, 80), stateful_step_count=30, deadline=None)

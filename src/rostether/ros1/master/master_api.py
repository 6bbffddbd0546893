"""The Master API: every call answers `[code, status message, value]`.

Code 1 is success, 0 failure, -1 the caller's error; codes, values and messages are those of rosmaster, which
scripts rely on. No I/O: nodes are notified through the given `NodeCalls`.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Awaitable, Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

from rostether.errors import GraphError
from rostether.graph.ports import NAME_TAKEN
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits
from rostether.ros1.long_work import run_at_once
from rostether.ros1.master.argument_checks import (
    MAX_NAME_LENGTH,
    BadArgumentError,
    Check,
    any_value,
    api_of,
    name_of,
    param_key,
    some_value,
    subgraph,
    topic_type,
)
from rostether.ros1.master.notices import NodeCalls, TopicNotices
from rostether.ros1.master.parameter_api import Answer, ParameterApi, refusal
from rostether.ros1.master.parameter_tree import ParameterTree
from rostether.ros1.master.registrations import ANY_TYPE, EntryKind, Registrations
from rostether.xmlrpc.values import XmlRpcValue

_log = logging.getLogger("rostether.ros1.master")

_topic = name_of("topic", may_be_root=False)
_service = name_of("service", may_be_root=False)
_node = name_of("node")
_caller_api = api_of("caller_api")
_service_api = api_of("service_api")


class _Method(NamedTuple):
    function: Callable[..., Answer | Awaitable[Answer]]
    checks: tuple[Check, ...]
    error_value: XmlRpcValue


class MasterApi:
    """The methods of one master over its tables; `on_shutdown` is called when a client asks it to stop.

    `work_later` runs the steps of long work in slices. `uri` is the answer of getUri: set it once the server
    listens.
    """

    def __init__(
        self,
        node_calls: NodeCalls,
        on_shutdown: Callable[[str], None],
        limits: GraphLimits = DEFAULT_GRAPH_LIMITS,
        work_later: Callable[[Iterator[None]], None] = run_at_once,
    ) -> None:
        self.registrations = Registrations()
        self.parameters = ParameterTree(limits)
        self._parameter_api = ParameterApi(self.parameters, self.registrations, node_calls, self._register)
        self.uri = ""
        self._node_calls = node_calls
        self._on_shutdown = on_shutdown
        self._topic_notices = TopicNotices(self.registrations, node_calls, work_later)

    def dispatch(self) -> dict[str, Callable[..., Any]]:
        """Return the table of methods, by their XML-RPC names; those of long work return awaitables."""
        params = self._parameter_api
        methods = {
            "shutdown": _Method(self._shutdown, (any_value,), 0),
            "getUri": _Method(lambda _caller: (1, "", self.uri), (), ""),
            "getPid": _Method(lambda _caller: (1, "", os.getpid()), (), -1),
            "deleteParam": _Method(params.delete_param, (param_key,), 0),
            "setParam": _Method(params.set_param, (param_key, some_value), 0),
            "getParam": _Method(params.get_param, (param_key,), 0),
            "searchParam": _Method(params.search_param, (param_key,), 0),
            "subscribeParam": _Method(params.subscribe_param, (_caller_api, param_key), 0),
            "unsubscribeParam": _Method(params.unsubscribe_param, (_caller_api, param_key), 0),
            "hasParam": _Method(params.has_param, (param_key,), False),
            "getParamNames": _Method(params.get_param_names, (), []),
            "registerService": _Method(self._register_service, (_service, _service_api, _caller_api), 0),
            "lookupService": _Method(self._lookup_service, (_service,), ""),
            "unregisterService": _Method(self._unregister_service, (_service, _service_api), 0),
            "registerSubscriber": _Method(self._register_subscriber, (_topic, topic_type, _caller_api), []),
            "unregisterSubscriber": _Method(self._unregister_subscriber, (_topic, _caller_api), 0),
            "registerPublisher": _Method(self._register_publisher, (_topic, topic_type, _caller_api), []),
            "unregisterPublisher": _Method(self._unregister_publisher, (_topic, _caller_api), 0),
            "lookupNode": _Method(self._lookup_node, (_node,), ""),
            "getPublishedTopics": _Method(self._get_published_topics, (subgraph,), 0),
            "getTopicTypes": _Method(self._get_topic_types, (), []),
            "getSystemState": _Method(self._get_system_state, (), [[], [], []]),
        }
        return {name: partial(self._invoke, method) for name, method in methods.items()}

    def _invoke(self, method: _Method, *args: XmlRpcValue) -> Answer | Awaitable[Answer]:
        if not args:
            return -1, "missing required caller_id parameter", method.error_value
        if len(args) != len(method.checks) + 1:
            return -1, "Error: bad call arity", method.error_value
        caller_id = args[0]
        if not isinstance(caller_id, str):
            return -1, "caller_id must be a string", method.error_value
        if len(caller_id) > MAX_NAME_LENGTH or not caller_id.isprintable():
            return -1, "caller_id contains illegal chars", method.error_value
        try:
            checked = [check(value, caller_id) for check, value in zip(method.checks, args[1:], strict=True)]
            return method.function(caller_id, *checked)
        except BadArgumentError as error:
            return -1, str(error), method.error_value
        except GraphError as error:
            return refusal(error, method.error_value)

    def drop_node(self, name: str) -> None:
        """Remove a dead node with all its registrations, and notify the subscribers of its topics."""
        if name in self.registrations.nodes:
            self._topic_notices.send_later(self.registrations.drop(name).topics)

    def _shutdown(self, caller_id: str, reason: XmlRpcValue) -> Answer:
        self._on_shutdown(f"shutdown request from {caller_id}: {reason!r:.200}")
        return 1, "shutdown", 0

    def _register(
        self, kind: EntryKind, key: str, caller_id: str, caller_api: str, service_api: str = ""
    ) -> None:
        node = self.registrations.nodes.get(caller_id)
        if kind is EntryKind.SERVICE:
            replaced = self.registrations.register_service(key, caller_id, caller_api, service_api)
        else:
            replaced = self.registrations.register(kind, key, caller_id, caller_api)
        if replaced is not None:
            _log.info("%s registered again: the old node at %s is shut down", caller_id, replaced.api)
            reason = f"[{caller_id}] Reason: {NAME_TAKEN}"
            self._node_calls.shut_down(replaced.api, reason)
            self._topic_notices.send_later(replaced.topics)
        if node is None or replaced is not None:
            self._node_calls.ping(caller_api)

    # Services

    def _register_service(self, caller_id: str, service: str, service_api: str, caller_api: str) -> Answer:
        self._register(EntryKind.SERVICE, service, caller_id, caller_api, service_api)
        _log.debug("+SERVICE [%s] %s %s", service, caller_id, caller_api)
        return 1, f"Registered [{caller_id}] as provider of [{service}]", 1

    def _unregister_service(self, caller_id: str, service: str, service_api: str) -> Answer:
        if caller_id not in self.registrations.nodes:
            return 1, f"[{caller_id}] is not a registered node", 0
        if not self.registrations.unregister_service(service, caller_id, service_api):
            return 1, f"[{service_api}] is no longer the current service api handle for [{service}]", 0
        _log.debug("-SERVICE [%s] %s %s", service, caller_id, service_api)
        return 1, f"Unregistered [{caller_id}] as provider of [{service}]", 1

    def _lookup_service(self, _caller_id: str, service: str) -> Answer:
        uri = self.registrations.service_api(service)
        return (1, f"rosrpc URI: [{uri}]", uri) if uri else (-1, "no provider", "")

    # Topics

    def _register_publisher(self, caller_id: str, topic: str, type_name: str, caller_api: str) -> Answer:
        self._register(EntryKind.PUBLISHER, topic, caller_id, caller_api)
        self.registrations.learn_type(topic, type_name, from_publisher=True)
        self._topic_notices.send(topic)
        _log.debug("+PUB [%s] %s %s", topic, caller_id, caller_api)
        subscribers = self.registrations.apis(EntryKind.SUBSCRIBER, topic)
        return 1, f"Registered [{caller_id}] as publisher of [{topic}]", subscribers

    def _unregister_publisher(self, caller_id: str, topic: str, caller_api: str) -> Answer:
        answer = self._unregister(EntryKind.PUBLISHER, caller_id, topic, caller_api)
        if answer[2]:
            self._topic_notices.send(topic)
        return answer

    def _register_subscriber(self, caller_id: str, topic: str, type_name: str, caller_api: str) -> Answer:
        self._register(EntryKind.SUBSCRIBER, topic, caller_id, caller_api)
        self.registrations.learn_type(topic, type_name, from_publisher=False)
        _log.debug("+SUB [%s] %s %s", topic, caller_id, caller_api)
        return 1, f"Subscribed to [{topic}]", self.registrations.apis(EntryKind.PUBLISHER, topic)

    def _unregister_subscriber(self, caller_id: str, topic: str, caller_api: str) -> Answer:
        return self._unregister(EntryKind.SUBSCRIBER, caller_id, topic, caller_api)

    def _unregister(self, kind: EntryKind, caller_id: str, topic: str, caller_api: str) -> Answer:
        if caller_id not in self.registrations.nodes:
            return 1, f"[{caller_id}] is not a registered node", 0
        if not self.registrations.unregister(kind, topic, caller_id, caller_api):
            return 1, f"[{caller_id}] is not a known provider of [{topic}]", 0
        _log.debug("-%s [%s] %s %s", kind.name[:3], topic, caller_id, caller_api)
        return 1, f"Unregistered [{caller_id}] as provider of [{topic}]", 1

    # Graph state

    def _lookup_node(self, _caller_id: str, name: str) -> Answer:
        node = self.registrations.nodes.get(name)
        return (1, "node api", node.api) if node else (-1, f"unknown node [{name}]", "")

    def _get_published_topics(self, _caller_id: str, space: str) -> Answer:
        prefix = space if not space or space.endswith("/") else f"{space}/"
        types = self.registrations.topic_types
        topics = self.registrations.keys(EntryKind.PUBLISHER)
        # None for a topic that is omitted, so that long tables are written in slices.
        found = ((each, types.get(each, ANY_TYPE)) if each.startswith(prefix) else None for each in topics)
        return 1, "current topics", found

    def _get_topic_types(self, _caller_id: str) -> Answer:
        types = self.registrations.topic_types
        return 1, "current system state", list(types.items())

    def _get_system_state(self, _caller_id: str) -> Answer:
        kinds = (EntryKind.PUBLISHER, EntryKind.SUBSCRIBER, EntryKind.SERVICE)
        return 1, "current system state", [self.registrations.state(kind) for kind in kinds]

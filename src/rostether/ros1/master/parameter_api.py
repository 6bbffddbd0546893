"""The Parameter Server API: every call answers `[code, status message, value]`, as in `master_api.py`."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable, Iterator
from typing import Any, TypeAlias

from rostether.errors import GraphError, UnknownNameError
from rostether.ros1.long_work import run_in_slices
from rostether.ros1.master.argument_checks import resolve
from rostether.ros1.master.notices import NodeCalls
from rostether.ros1.master.parameter_tree import ParameterTree, updates, watch_key
from rostether.ros1.master.registrations import EntryKind, Registrations
from rostether.xmlrpc.values import XmlRpcValue

Answer: TypeAlias = tuple[int, str, Any]

_log = logging.getLogger("rostether.ros1.master")


class ParameterApi:
    """The methods for parameters; `register` registers a node as a watcher."""

    def __init__(
        self,
        parameters: ParameterTree,
        registrations: Registrations,
        node_calls: NodeCalls,
        register: Callable[[EntryKind, str, str, str], None],
    ) -> None:
        self._parameters = parameters
        self._registrations = registrations
        self._node_calls = node_calls
        self._register = register

    def set_param(self, caller_id: str, key: str, value: XmlRpcValue) -> Answer | Awaitable[Answer]:
        """Set a parameter or a tree."""
        name = resolve(key, caller_id)
        steps = self._parameters.set_steps(name, value)
        # Only a large value needs more than one step.
        for _ in steps:
            return self._set_large_param(steps, name, value, caller_id)
        return self._finish_set(name, value, caller_id)

    async def _set_large_param(
        self, steps: Iterator[None], name: str, value: XmlRpcValue, caller_id: str
    ) -> Answer:
        try:
            await run_in_slices(steps)
        except GraphError as error:
            return refusal(error, 0)
        return self._finish_set(name, value, caller_id)

    def _finish_set(self, name: str, value: XmlRpcValue, caller_id: str) -> Answer:
        self._notify_watchers(name, value, caller_id)
        _log.debug("+PARAM [%s] by %s", name, caller_id)
        return 1, f"parameter {name} set", 0

    def delete_param(self, caller_id: str, key: str) -> Answer | Awaitable[Answer]:
        """Delete a parameter or a tree."""
        name = resolve(key, caller_id)
        steps = self._parameters.delete_steps(name)
        try:
            # As in `set_param`.
            for _ in steps:
                return self._delete_large_param(steps, name, caller_id)
        except UnknownNameError:
            return _not_set(name)
        return self._finish_delete(name, caller_id)

    async def _delete_large_param(self, steps: Iterator[None], name: str, caller_id: str) -> Answer:
        try:
            await run_in_slices(steps)
        except UnknownNameError:
            return _not_set(name)
        return self._finish_delete(name, caller_id)

    def _finish_delete(self, name: str, caller_id: str) -> Answer:
        self._notify_watchers(name, {}, None)
        _log.debug("-PARAM [%s] by %s", name, caller_id)
        return 1, f"parameter {name} deleted", 0

    def get_param(self, caller_id: str, key: str) -> Answer:
        """Return a parameter or a tree."""
        name = resolve(key, caller_id)
        try:
            return 1, f"Parameter [{name}]", self._parameters.get(name)
        except UnknownNameError:
            return -1, f"Parameter [{name}] is not set", 0

    def has_param(self, caller_id: str, key: str) -> Answer:
        """Return whether a parameter is set."""
        name = resolve(key, caller_id)
        return 1, name, self._parameters.has(name)

    def get_param_names(self, _caller_id: str) -> Answer:
        """Return the names of all parameters."""
        return 1, "Parameter names", self._parameters.names()

    def search_param(self, caller_id: str, key: str) -> Answer:
        """Find the nearest parameter of a name, upward from the caller."""
        if key.startswith("~"):
            return 0, "Internal failure: invalid key", 0
        if not caller_id.startswith("/"):
            return 0, "Internal failure: namespace must be global", 0
        found = self._parameters.search(caller_id, key)
        if found is None:
            return -1, f"Cannot find parameter [{key}] in an upwards search", ""
        return 1, f"Found [{found}]", found

    def subscribe_param(self, caller_id: str, caller_api: str, key: str) -> Answer:
        """Register a watcher of a parameter, and return the value."""
        name = resolve(key, caller_id)
        value = self._parameters.get(name) if self._parameters.has(name) else {}
        self._register(EntryKind.PARAM, watch_key(name), caller_id, caller_api)
        return 1, f"Subscribed to parameter [{name}]", value

    def unsubscribe_param(self, caller_id: str, caller_api: str, key: str) -> Answer:
        """Unregister a watcher of a parameter."""
        name = resolve(key, caller_id)
        self._registrations.unregister(EntryKind.PARAM, watch_key(name), caller_id, caller_api)
        return 1, f"Unsubscribe to parameter [{name}]", 1

    def _notify_watchers(self, name: str, value: XmlRpcValue, changed_by: str | None) -> None:
        for update in updates(self._registrations.keys(EntryKind.PARAM), name, value):
            for watcher, api in self._registrations.members(EntryKind.PARAM, update.watched).items():
                # The node that sets a parameter already knows its value.
                if not (update.is_own_change and watcher == changed_by):
                    self._node_calls.param_update(api, update.key, update.value)


def _not_set(name: str) -> Answer:
    return -1, f"parameter [{name}] is not set", 0


def refusal(error: GraphError, value: XmlRpcValue) -> Answer:
    """Return the answer for a call with invalid arguments."""
    return -1, f"Error: invalid arguments: {error}", value

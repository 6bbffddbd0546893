"""rosapi's services for parameters: values are JSON strings, because fields of services have fixed types.

On a ROS 2 graph, parameters have names such as `/node:name`, as in rosapi; the ROS 1 form also works.
"""

from __future__ import annotations

import json
from typing import Any

from rostether.errors import SerializationError, UnknownNameError
from rostether.gateways.rosbridge.settings import check_allowed, matches
from rostether.gateways.rosbridge.values import write_json
from rostether.graph.ports import Graph, ParamValue

# The depth of trees on a parameter server: the limit of XML-RPC documents.
MAX_NESTING = 100


class ParameterServices:
    """Answers requests about parameters; clients may use the names that match `globs`, all if it is None.

    Methods raise AccessDeniedError for other names, and GraphError.
    """

    def __init__(self, graph: Graph, globs: tuple[str, ...] | None, *, is_ros2: bool) -> None:
        self._graph = graph
        self._globs = globs
        self._is_ros2 = is_ros2

    async def get(self, name: str, default: str) -> str:
        """Return a parameter's value in JSON: `default` if it is not set, null if `default` is also empty."""
        try:
            value = await self._graph.get_param(self._name(name))
        except UnknownNameError:
            return write_json(_default(default))
        return write_json(_plain(value))

    async def set(self, name: str, text: str) -> None:
        """Set a parameter to a value in JSON. Raises SerializationError for a text that is not valid JSON."""
        value = _read(text)
        await self._graph.set_param(self._name(name), value)

    async def has(self, name: str) -> bool:
        """Return whether a parameter is set; False if clients may not use it."""
        return matches(name, self._globs) and await self._graph.has_param(self._name(name))

    async def delete(self, name: str) -> None:
        """Delete a parameter, if there is one."""
        full_name = self._name(name)
        if await self._graph.has_param(full_name):
            await self._graph.delete_param(full_name)

    async def search(self, name: str) -> str:
        """Return the full name of the nearest parameter of that name, or an empty string."""
        return await self._graph.search_param(self._name(name)) or ""

    async def names(self) -> list[str]:
        """Return the names of all parameters that clients may use, sorted."""
        names = await self._graph.list_params()
        if self._is_ros2:
            from rostether.ros2.parameters.parameter_name import locate

            nodes = (await self._graph.snapshot()).nodes
            found = [locate(name, nodes, self._graph.node_name) for name in names]
            names = [f"{each.node}:{each.path}" for each in found]
        return [name for name in names if matches(name, self._globs)]

    def _name(self, name: str) -> str:
        check_allowed(name, self._globs, "params_glob")
        return name.replace(":", "/").replace(".", "/") if self._is_ros2 else name


def _read(text: str) -> ParamValue:
    try:
        value = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise SerializationError(
            f'a parameter\'s value must be JSON, a string such as "\\"hello\\"": {error}'
        ) from None
    _check(value, 0)
    return value  # type: ignore[no-any-return]


def _check(value: Any, depth: int) -> None:
    if depth > MAX_NESTING:
        raise SerializationError(f"parameters can be nested at most {MAX_NESTING} levels deep")
    if value is None:
        raise SerializationError("a parameter cannot be null, or contain null; delete it instead")
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for each in value:
            _check(each, depth + 1)


def _default(text: str) -> Any:
    try:
        return json.loads(text) if text else None
    except (ValueError, RecursionError):
        return text


def _plain(value: ParamValue) -> Any:
    """Return a value for JSON; XML-RPC's binary data becomes text."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, list) else value

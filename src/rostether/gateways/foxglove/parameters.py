"""Parameters of a graph for clients: read, set, and watched once for all clients."""

from __future__ import annotations

import asyncio
import base64
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from rostether.errors import (
    AccessDeniedError,
    ConfigError,
    InvalidNameError,
    RostetherError,
    UnknownNameError,
)
from rostether.gateways.foxglove.client_messages import GivenParameter
from rostether.gateways.foxglove.settings import NameFilter
from rostether.graph.ports import Graph, ParamValue
from rostether.serde.plain_form import base64_text, plain_value

# The limit in one response; a large robot has a few thousand parameters.
MAX_PARAMETERS = 20_000

# On ROS 2 each parameter costs a request to its node: some in parallel are fast, and do not flood the node.
_ASKED_AT_ONCE = 16

# The limit of nested mappings and lists: deeper than real ones, and far below Python's recursion limit.
MAX_DEPTH = 64

_SPECIAL = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}
_FLOAT, _FLOATS, _BYTES = "float64", "float64_array", "byte_array"


class Parameters:
    """The parameters of one gateway."""

    def __init__(self, graph: Graph, offered: NameFilter) -> None:
        self._graph = graph
        self._offered = offered
        self._watched: dict[str, _WatchedParameter] = {}

    async def get(self, names: Sequence[str]) -> list[dict[str, Any]]:
        """Return the values of the names, or of all parameters; unset parameters are skipped.

        Raises GraphError.
        """
        if names:
            return await self._get_each([name for name in names if self._offers(name)])
        listed = await self.names()
        try:
            # On ROS 1, one request returns all of them.
            tree = await self._graph.get_param("/")
        except RostetherError:
            tree = None
        found = {name: _below(tree, name) for name in listed}
        rest = await self._get_each([name for name, value in found.items() if value is None])
        known = [describe(name, value) for name, value in found.items() if value is not None]
        return sorted(known + rest, key=lambda each: str(each["name"]))

    async def set(self, given: Iterable[GivenParameter]) -> tuple[list[dict[str, Any]], list[str]]:
        """Set or unset parameters; return the new values, and a line for each that could not be set."""
        now: list[dict[str, Any]] = []
        errors: list[str] = []
        for each in given:
            before: ParamValue = None
            try:
                self._check(each.name)
                before = await self._value(each.name)
                value = None if each.value is None else given_value(each, before)
                if value is not None:
                    await self._graph.set_param(each.name, value)
                elif before is not None:
                    await self._graph.delete_param(each.name)
            except RostetherError as error:
                errors.append(f"parameter {each.name[:80]} is not set: {error}")
                value = before
            now.append(describe(each.name, value))
        return now, errors

    async def names(self) -> list[str]:
        """Return the names of all parameters that are offered. Raises GraphError."""
        return [name for name in await self._graph.list_params() if self._offers(name)][:MAX_PARAMETERS]

    async def watch(self, name: str, on_change: Callable[[dict[str, Any]], None]) -> None:
        """Call back with the value now and after each change. Raises InvalidNameError, GraphError."""
        self._check(name)
        watched = self._watched.get(name)
        if watched is None:
            watched = self._watched[name] = _WatchedParameter(name, self._graph)
        watched.listeners.append(on_change)
        if watched.latest is not None:
            on_change(watched.latest)
        try:
            await asyncio.shield(watched.opening)
        except BaseException:
            await self.unwatch(name, on_change)
            raise

    async def unwatch(self, name: str, on_change: Callable[[dict[str, Any]], None]) -> None:
        """Stop calling back. Idempotent."""
        watched = self._watched.get(name)
        if watched is None or on_change not in watched.listeners:
            return
        watched.listeners.remove(on_change)
        if not watched.listeners:
            del self._watched[name]
            await watched.close()

    async def close(self) -> None:
        """Stop all watches."""
        watched, self._watched = list(self._watched.values()), {}
        await asyncio.gather(*(each.close() for each in watched))

    def _offers(self, name: str) -> bool:
        if self._offered.patterns is None:
            return True
        try:
            return self._offered.includes(self._graph.resolve(name))
        except InvalidNameError:
            return False

    def _check(self, name: str) -> None:
        if not self._offers(name):
            raise AccessDeniedError("clients may not use it; add it to the gateway's ~param_whitelist")

    async def _get_each(self, names: Sequence[str]) -> list[dict[str, Any]]:
        at_once = asyncio.Semaphore(_ASKED_AT_ONCE)

        async def get(name: str) -> dict[str, Any] | None:
            async with at_once:
                try:
                    value = await self._value(name)
                except RostetherError:
                    return None
            return None if value is None else describe(name, value)

        found = await asyncio.gather(*(get(name) for name in names))
        return [each for each in found if each is not None]

    async def _value(self, name: str) -> ParamValue:
        try:
            return await self._graph.get_param(name)
        except UnknownNameError:
            return None


class _WatchedParameter:
    """A parameter that is watched once for all clients, and its latest value."""

    def __init__(self, name: str, graph: Graph) -> None:
        self.listeners: list[Callable[[dict[str, Any]], None]] = []
        self.latest: dict[str, Any] | None = None
        self.opening = asyncio.ensure_future(graph.watch_param(name, self._handle_change))
        self._name = name

    async def close(self) -> None:
        await asyncio.wait([self.opening])
        if not self.opening.cancelled() and self.opening.exception() is None:
            await self.opening.result().close()

    def _handle_change(self, value: ParamValue) -> None:
        self.latest = describe(self._name, value)
        for listener in list(self.listeners):
            listener(self.latest)


def _below(tree: ParamValue, name: str) -> ParamValue:
    for part in name.strip("/").split("/"):
        if not isinstance(tree, dict) or part not in tree:
            return None
        tree = tree[part]
    return tree


def describe(name: str, value: ParamValue) -> dict[str, Any]:
    """Return a parameter for clients; an unset one has no value."""
    if value is None:
        return {"name": name}
    described: dict[str, Any] = {"name": name, "value": plain_value(value, base64_text)}
    if isinstance(value, bytes):
        described["type"] = _BYTES
    elif _is_finite_float(value):
        described["type"] = _FLOAT
    elif isinstance(value, list) and value and all(map(_is_finite_float, value)):
        described["type"] = _FLOATS
    return described


def _is_finite_float(value: ParamValue) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def given_value(given: GivenParameter, before: ParamValue) -> ParamValue:
    """Return the value to set; a whole number for a float parameter becomes a float. Raises ConfigError."""
    value = given.value
    if given.type == _FLOAT or (given.type is None and isinstance(before, float)):
        return _float(given.name, value)
    if given.type == _FLOATS or (given.type is None and _is_float_list(before) and isinstance(value, list)):
        if not isinstance(value, list):
            raise ConfigError(f"parameter {given.name} must be a list of numbers")
        return [_float(given.name, each) for each in value]
    if given.type == _BYTES:
        try:
            return base64.b64decode(value, validate=True)
        except (ValueError, TypeError):
            raise ConfigError(f"parameter {given.name} of type byte_array must be base64") from None
    return _native(given.name, value)


def _float(name: str, value: Any) -> float:
    if isinstance(value, str) and value in _SPECIAL:
        return _SPECIAL[value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"parameter {name} must be a number, not {str(value)[:40]!r}")
    try:
        return float(value)
    except OverflowError:
        raise ConfigError(f"parameter {name} must be a smaller number: it is too large for a float") from None


def _is_float_list(value: ParamValue) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(each, float) for each in value)


def _native(name: str, value: Any, depth: int = 0) -> ParamValue:
    if depth > MAX_DEPTH:
        raise ConfigError(f"parameter {name} must be nested at most {MAX_DEPTH} levels deep")
    if isinstance(value, dict):
        return {str(key): _native(name, each, depth + 1) for key, each in value.items()}
    if isinstance(value, list):
        return [_native(name, each, depth + 1) for each in value]
    if isinstance(value, bool | int | float | str | bytes):
        return value
    raise ConfigError(f"parameter {name} cannot contain null inside a value; remove it")

"""Watching parameters: the master sends changes at, above and below the subscribed names."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from rostether.errors import GraphError, UnknownNameError
from rostether.graph.parameter_watch import ParameterWatch
from rostether.graph.ports import ParamValue
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.ros1.node.master_client import MasterClient
from rostether.xmlrpc.values import XmlRpcValue

_log = logging.getLogger("rostether.ros1")


class ParameterWatches:
    """All watches of one node."""

    def __init__(self, master: MasterClient, node_uri: str) -> None:
        self._master = master
        self._node_uri = node_uri
        self._watches: dict[str, list[ParameterWatch]] = {}
        self._fetches: set[asyncio.Task[None]] = set()

    async def add(self, name: str, on_change: Callable[[ParamValue], None]) -> ParameterWatch:
        """Call back with the value now and after every change. Raises GraphError."""
        watch = ParameterWatch(name, on_change, self.remove)
        self._watches.setdefault(name, []).append(watch)
        try:
            watch.report(_unset_as_none(await self._master.subscribe_param(name, self._node_uri)))
        except GraphError:
            self._forget(watch)
            raise
        return watch

    def update(self, key: str, value: XmlRpcValue) -> bool:
        """Apply a change from the master; return False if this node does not watch the name.

        Masters do not send a node its own changes, see `changed_by_us`.
        """
        key = "/" + key.strip("/")
        watches = list(self._watches.get(key, ()))
        for watch in watches:
            watch.report(_unset_as_none(value))
        # A change below a watched tree: only the master knows the whole tree now.
        return self._fetch_soon(lambda name: _is_below(key, name)) or bool(watches)

    def changed_by_us(self, key: str) -> None:
        """Report that this node has set or deleted a parameter."""
        self._fetch_soon(lambda name: name == key or _is_below(key, name) or _is_below(name, key))

    def _fetch_soon(self, concerns: Callable[[str], bool]) -> bool:
        names = [name for name in self._watches if concerns(name)]
        for name in names:
            start_task(self._fetches, self._fetch(name))
        return bool(names)

    async def subscribe_again(self) -> None:
        """Register all watches with a master that has lost them. Raises GraphError."""
        for name, watches in list(self._watches.items()):
            value = _unset_as_none(await self._master.subscribe_param(name, self._node_uri))
            for watch in list(watches):
                watch.report(value)

    async def remove(self, watch: ParameterWatch) -> None:
        """End a watch."""
        if self._forget(watch):
            try:
                await self._master.unsubscribe_param(watch.name, self._node_uri)
            except GraphError as error:
                _log.debug("cannot unsubscribe from %s: %s", watch.name, error)

    async def close(self) -> None:
        """End all watches. Idempotent."""
        await cancel_all(*self._fetches)
        watches = [watch for named in self._watches.values() for watch in named]
        await asyncio.gather(*(watch.close() for watch in watches))

    def _forget(self, watch: ParameterWatch) -> bool:
        """Drop a watch; return True if it was the last one of its name."""
        watches = self._watches.get(watch.name, [])
        if watch not in watches:
            return False
        watches.remove(watch)
        if watches:
            return False
        del self._watches[watch.name]
        return True

    async def _fetch(self, name: str) -> None:
        try:
            value = await self._master.get_param(name)
        except UnknownNameError:
            value = None
        except GraphError as error:
            _log.debug("cannot read %s after a change below it: %s", name, error)
            return
        for watch in list(self._watches.get(name, ())):
            watch.report(value)


def _is_below(name: str, tree: str) -> bool:
    return name.startswith(tree.rstrip("/") + "/")


def _unset_as_none(value: XmlRpcValue) -> ParamValue:
    # Masters report an unset parameter as an empty dict.
    return None if value == {} else value

"""The calls of a master to nodes: updates for each node in order; a silent node does not delay the others.

Each node's URI has its own outbox, and its own task that sends it. An update of a topic or parameter
replaces an older one that was not sent yet. If a node does not answer, its updates are kept and sent again,
less and less often: it may be stopped in a debugger. If its port refuses connections repeatedly, the node has
ended, and `on_gone` is called.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Collection

from msgspec import Struct, field

from rostether.errors import ConfigError, GraphError, SerializationError
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.tasks import cancel_all
from rostether.ros1.xmlrpc_client import XmlRpcClient
from rostether.xmlrpc.values import XmlRpcValue

_CALLER = "/master"
# A node answers a notice within milliseconds unless it hangs; then it is tried again.
_CALL_TIMEOUT_S = 5.0
_FIRST_RETRY_S = 1.0
_MAX_RETRY_S = 30.0
# Two refusals in a row are not a restart of a listener: the node has ended.
_REFUSALS_UNTIL_GONE = 2
# The end of a node is detected immediately when its kept connection breaks; pings find connections that broke
# unnoticed. Servers close idle connections after a longer time.
PING_INTERVAL_S = 30.0
# One entry for each topic or parameter that a node watches; a node that hangs loses the oldest beyond this.
_MAX_PENDING = 4096
# Each has a document of up to a few MB until the node has received it; small calls are not limited.
_LARGE_CALLS_AT_ONCE = 16
# A list of this many URIs is about 4 KB.
_LARGE_LENGTH = 64
# Descriptors are commonly limited to 1024 per process, and most are for callers of the master.
_MAX_KEPT_CONNECTIONS = 256

_log = logging.getLogger("rostether.ros1.master")


class _Outbox(Struct):
    client: XmlRpcClient
    # {(method, key): arguments}, in the order of sending.
    pending: dict[tuple[str, str], tuple[XmlRpcValue, ...]] = field(default_factory=dict)
    task: asyncio.Task[None] | None = None
    refusals: int = 0


class NodeCallQueue:
    """Delivers a master's calls to nodes; calls `on_gone(api)` for a URI at which no node listens.

    The answers of nodes are ignored: rospy refuses updates of a parameter that it will watch in a moment.
    """

    def __init__(self, on_gone: Callable[[str], None]) -> None:
        self._on_gone = on_gone
        self._outboxes: dict[str, _Outbox] = {}
        self._large_calls = asyncio.Semaphore(_LARGE_CALLS_AT_ONCE)
        self._is_closed = False

    def publisher_update(self, api: str, topic: str, publishers: list[str]) -> None:
        """Queue a topic's publishers for a subscriber."""
        self._queue(api, ("publisherUpdate", topic), (topic, publishers))  # type: ignore[arg-type]

    def param_update(self, api: str, key: str, value: XmlRpcValue) -> None:
        """Queue a parameter's value for a watcher."""
        self._queue(api, ("paramUpdate", key), (key, value))

    def shut_down(self, api: str, reason: str) -> None:
        """Queue a request to shut down; it replaces all other requests."""
        if api in self._outboxes:
            self._outboxes[api].pending.clear()
        self._queue(api, ("shutdown", ""), (reason,))

    def ping(self, api: str) -> None:
        """Queue a call that only checks whether the node answers."""
        self._queue(api, ("getPid", ""), ())

    def retain(self, apis: Collection[str]) -> None:
        """Forget the nodes that are not among `apis`, except a request to shut down."""
        for api, outbox in list(self._outboxes.items()):
            if api not in apis and ("shutdown", "") not in outbox.pending:
                del self._outboxes[api]
                outbox.client.disconnect()
                if outbox.task is not None:
                    outbox.task.cancel()

    async def close(self) -> None:
        """Drop all calls. Idempotent."""
        self._is_closed = True
        await cancel_all(*(outbox.task for outbox in self._outboxes.values() if outbox.task is not None))
        for outbox in self._outboxes.values():
            await outbox.client.close()
        self._outboxes.clear()

    def _queue(self, api: str, what: tuple[str, str], arguments: tuple[XmlRpcValue, ...]) -> None:
        if self._is_closed:
            return
        outbox = self._outboxes.get(api)
        if outbox is None:
            try:
                client = XmlRpcClient(api, timeout_s=_CALL_TIMEOUT_S, on_lost=lambda: self.ping(api))
            except ConfigError as error:
                _log.debug("changes cannot be sent to a node: %s", error)
                return
            outbox = self._outboxes[api] = _Outbox(client)
        # A call that already waits moves to the end: an update of a namespace in between must not undo it.
        outbox.pending.pop(what, None)
        outbox.pending[what] = arguments
        if len(outbox.pending) > _MAX_PENDING:
            (method, key), _ = next(iter(outbox.pending.items()))
            del outbox.pending[method, key]
            _log.warning("%s does not answer: it will not receive the change of %s", api, key)
        if outbox.task is None:
            outbox.task = asyncio.get_running_loop().create_task(self._deliver(api, outbox))

    async def _deliver(self, api: str, outbox: _Outbox) -> None:
        backoff = Backoff(first_s=_FIRST_RETRY_S, limit_s=_MAX_RETRY_S)
        while outbox.pending:
            what, arguments = next(iter(outbox.pending.items()))
            try:
                await self._call(api, outbox, what, arguments)
            except _NotDeliveredError as error:
                if what[0] == "shutdown":
                    # Usually, the old node of that name has already ended.
                    outbox.pending.clear()
                    continue
                outbox.refusals = outbox.refusals + 1 if error.is_refused else 0
                if outbox.refusals >= _REFUSALS_UNTIL_GONE:
                    del self._outboxes[api]
                    self._on_gone(api)
                    return
                await asyncio.sleep(backoff.next_delay_s())
                continue
            outbox.refusals = 0
            backoff.reset()
            # An update may have replaced the arguments during the call.
            if outbox.pending.get(what) is arguments:
                del outbox.pending[what]
        outbox.task = None
        if len(self._outboxes) > _MAX_KEPT_CONNECTIONS:
            outbox.client.disconnect()

    async def _call(
        self, api: str, outbox: _Outbox, what: tuple[str, str], arguments: tuple[XmlRpcValue, ...]
    ) -> None:
        method, key = what
        try:
            if any(_is_large(each) for each in arguments):
                async with self._large_calls:
                    await outbox.client.call(method, _CALLER, *arguments)
            else:
                await outbox.client.call(method, _CALLER, *arguments)
        except SerializationError as error:
            _log.warning("%s cannot be sent to %s: %s", key, api, error)
            return
        except GraphError as error:
            cause = error.__cause__
            if isinstance(cause, OSError) or cause is None:
                _log.debug("%s", error)
                raise _NotDeliveredError(is_refused=isinstance(cause, ConnectionRefusedError)) from error
            # It answered with a fault, or not with XML-RPC: a retry would not help.
            _log.debug("%s", error)


def _is_large(value: XmlRpcValue) -> bool:
    if isinstance(value, (str, bytes)):
        return len(value) > _LARGE_LENGTH * _LARGE_LENGTH
    return isinstance(value, dict) or (isinstance(value, list) and len(value) > _LARGE_LENGTH)


class _NotDeliveredError(Exception):
    def __init__(self, *, is_refused: bool) -> None:
        super().__init__()
        self.is_refused = is_refused

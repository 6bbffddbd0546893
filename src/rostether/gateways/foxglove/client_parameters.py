"""The parameters that one client reads, sets and watches."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from rostether.errors import RostetherError
from rostether.gateways.foxglove import client_messages as requests
from rostether.gateways.foxglove import server_messages as replies
from rostether.gateways.foxglove.client_work import ClientWork
from rostether.gateways.foxglove.foxglove_context import FoxgloveContext


class ClientParameters:
    """Handles one client's requests about parameters.

    `send` sends the responses to the client, and `report_error` reports an error.
    """

    def __init__(
        self,
        context: FoxgloveContext,
        work: ClientWork,
        send: Callable[[str], None],
        report_error: Callable[[str], None],
    ) -> None:
        self._context = context
        self._work = work
        self._send = send
        self._report_error = report_error
        self._watched: set[str] = set()
        self._changed: dict[str, dict[str, Any]] = {}
        self.handlers: dict[type, Callable[[Any], None]] = {
            requests.GetParameters: self._get,
            requests.SetParameters: self._set,
            requests.SubscribeParameters: self._subscribe,
            requests.UnsubscribeParameters: self._unsubscribe,
        }

    def close(self) -> None:
        """Stop all watches."""
        self._unwatch_each(tuple(self._watched))

    def _get(self, request: requests.GetParameters) -> None:
        async def get() -> None:
            values = await self._context.parameters.get(request.parameter_names)
            self._send(replies.parameter_values(values, request.id))

        self._ask(get, "parameters cannot be read")

    def _set(self, request: requests.SetParameters) -> None:
        async def set_values() -> None:
            values, errors = await self._context.parameters.set(request.parameters)
            for text in errors:
                self._report_error(text)
            if request.id is not None:
                self._send(replies.parameter_values(values, request.id))

        self._ask(set_values, "parameters cannot be set")

    def _subscribe(self, request: requests.SubscribeParameters) -> None:
        if request.parameter_names:
            self._watch_each(request.parameter_names)
            return

        async def watch_all() -> None:
            self._watch_each(await self._context.parameters.names())

        self._ask(watch_all, "parameters cannot be watched")

    def _unsubscribe(self, request: requests.UnsubscribeParameters) -> None:
        self._unwatch_each(request.parameter_names or tuple(self._watched))

    def _ask(self, work: Callable[[], Coroutine[Any, Any, None]], failed: str) -> None:
        async def in_time() -> None:
            async with asyncio.timeout(self._context.limits.parameters_timeout_s):
                await work()

        self._work.ask(
            in_time, lambda text: self._report_error(f"{failed}: {text}"), self._context.limits.calls
        )

    def _watch_each(self, names: Sequence[str]) -> None:
        for name in names:
            if name in self._watched:
                continue
            if len(self._watched) >= self._context.limits.watched_parameters:
                self._report_error(
                    f"a client may watch at most {self._context.limits.watched_parameters} parameters; "
                    "unsubscribe some"
                )
                return
            self._watched.add(name)
            self._work.start(self._watch(name))

    async def _watch(self, name: str) -> None:
        try:
            await self._context.parameters.watch(name, self._queue_change)
        except RostetherError as error:
            self._watched.discard(name)
            self._report_error(f"parameter {name[:80]} cannot be watched: {error}")

    def _unwatch_each(self, names: Sequence[str]) -> None:
        for name in names:
            if name in self._watched:
                self._watched.discard(name)
                self._context.run(self._context.parameters.unwatch(name, self._queue_change))

    def _queue_change(self, described: dict[str, Any]) -> None:
        # Many parameters are watched and set at once: one message has them all.
        if not self._changed:
            asyncio.get_running_loop().call_soon(self._send_changed)
        self._changed[described["name"]] = described

    def _send_changed(self) -> None:
        changed, self._changed = list(self._changed.values()), {}
        self._send(replies.parameter_values(changed))

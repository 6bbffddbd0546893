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

    def get(self, request: requests.GetParameters) -> None:
        """Answer with values."""

        async def get() -> None:
            values = await self._context.parameters.get(request.parameter_names)
            self._send(replies.parameter_values(values, request.id))

        self._ask(get, "parameters cannot be read")

    def set(self, request: requests.SetParameters) -> None:
        """Set values, and answer with the new values if requested."""

        async def set_values() -> None:
            values, errors = await self._context.parameters.set(request.parameters)
            for text in errors:
                self._report_error(text)
            if request.id is not None:
                self._send(replies.parameter_values(values, request.id))

        self._ask(set_values, "parameters cannot be set")

    def watch(self, request: requests.SubscribeParameters) -> None:
        """Report changes of the named parameters from now on, or of all if none are named."""
        if request.parameter_names:
            self._watch_each(request.parameter_names)
            return

        async def watch_all() -> None:
            self._watch_each(await self._context.parameters.names())

        self._ask(watch_all, "parameters cannot be watched")

    def unwatch(self, request: requests.UnsubscribeParameters) -> None:
        """Stop reporting changes of the named parameters, or of all if none are named."""
        self._unwatch_each(request.parameter_names or tuple(self._watched))

    def close(self) -> None:
        """Stop all watches."""
        self._unwatch_each(tuple(self._watched))

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

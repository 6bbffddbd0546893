"""One service that a node offers: a zenoh queryable and its token."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

import zenoh

from rostether.errors import RostetherError
from rostether.graph.callbacks import report_error
from rostether.graph.ports import ServiceHandler
from rostether.ros2.naming import dds_name
from rostether.ros2.qos import SERVICES_QOS
from rostether.ros2.type_support import ServiceSupport
from rostether.ros2.zenoh.attachment import Attachment, parse_attachment
from rostether.ros2.zenoh.entities import NodeEntities
from rostether.ros2.zenoh.foreign_threads import stay_known
from rostether.ros2.zenoh.handover import Handover
from rostether.ros2.zenoh.tokens import Kind, data_key

MAX_CALLS = 1000
"""Calls of one service at a time; a board answers one by one, and nobody waits for the thousandth."""


class ServiceServer:
    """A `graph.ports.ServiceServer`; calls run side by side."""

    def __init__(
        self,
        service: str,
        support: ServiceSupport,
        handler: ServiceHandler,
        *,
        node: NodeEntities,
        on_close: Callable[[ServiceServer], None],
    ) -> None:
        self.service = service
        self._support = support
        self._handler = handler
        self._on_close = on_close
        self._is_closed = False
        self._calls: set[asyncio.Task[None]] = set()
        type_name = dds_name(support.name)
        self._key = data_key(node.session.domain_id, service, type_name, support.type_hash)
        self._queue: Handover[zenoh.Query] = Handover(self._take, limit=MAX_CALLS)
        self._queryable = node.session.zenoh.declare_queryable(
            self._key, zenoh.handlers.Callback(self._put, indirect=False), complete=True
        )
        self._token = node.declare(Kind.SERVER, service, type_name, support.type_hash, SERVICES_QOS)

    async def close(self) -> None:
        """Unadvertise; calls under way fail. Idempotent."""
        if self._is_closed:
            return
        self._is_closed = True
        self._token.withdraw()
        self._queryable.undeclare()
        self._queue.close()
        for task in list(self._calls):
            task.cancel()
        await asyncio.gather(*self._calls, return_exceptions=True)
        self._on_close(self)

    def _put(self, query: zenoh.Query) -> None:
        stay_known()
        self._queue.put(query)

    def _take(self, queries: list[zenoh.Query]) -> None:
        for query in queries:
            if len(self._calls) >= MAX_CALLS:
                self._refuse(query, f"service {self.service} is busy with {MAX_CALLS} calls: try again later")
                continue
            task = asyncio.ensure_future(self._answer(query))
            self._calls.add(task)
            task.add_done_callback(self._calls.discard)

    async def _answer(self, query: zenoh.Query) -> None:
        with query:
            attachment = None if query.attachment is None else parse_attachment(query.attachment.to_bytes())
            if attachment is None or query.payload is None:
                self._refuse(query, f"a call of {self.service} without rmw_zenoh's attachment or a request")
                return
            try:
                request = self._support.request.from_cdr(query.payload.to_bytes())
                response = self._support.response.to_cdr(await self._handler(request))
            except asyncio.CancelledError:
                self._refuse(query, f"service {self.service} ended during the call")
                raise
            except RostetherError as error:
                self._refuse(query, str(error))
            except Exception as error:  # noqa: BLE001 - a user's mistake must not end the service
                report_error(f"handler of service {self.service}", error)
                self._refuse(query, f"error processing request: {error}")
            else:
                echo = Attachment(attachment.sequence, time.time_ns(), attachment.gid)
                query.reply(self._key, response, attachment=echo.encode())

    @staticmethod
    def _refuse(query: zenoh.Query, text: str) -> None:
        query.reply_err(text.encode("utf-8", "replace"))

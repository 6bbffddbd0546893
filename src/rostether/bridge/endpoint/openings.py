"""Opens and closes endpoints in the graph; for each name, the old endpoint closes before the new one opens.

An opening waits for earlier closings of its name, and a closing waits for the opening of its endpoint. Each
waits only for something older, so there is no deadlock. Each turn of the event loop starts one of them.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Coroutine
from typing import TypeAlias

from rostether.bridge.endpoint.publisher import PublisherEndpoint
from rostether.bridge.endpoint.service_client import ServiceClientEndpoint
from rostether.bridge.endpoint.service_server import ServiceServerEndpoint
from rostether.bridge.endpoint.subscriber import SubscriberEndpoint
from rostether.bridge.reporter import Notices, reason_of
from rostether.errors import DefinitionError, GraphError, InvalidNameError, TypeMismatchError
from rostether.graph.ports import Level
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.rosserial.events import ServiceAnnounced, ServiceRole, TopicRole

_LOG = logging.getLogger(__name__)

TopicEndpoint: TypeAlias = PublisherEndpoint | SubscriberEndpoint
ServiceEndpoint: TypeAlias = ServiceServerEndpoint | ServiceClientEndpoint
Endpoint: TypeAlias = TopicEndpoint | ServiceEndpoint
Role: TypeAlias = TopicRole | ServiceRole

# A role and name that only one endpoint may have, except topics that a board announces twice.
Slot: TypeAlias = tuple[Role, str]

# The longest pause before an endpoint that the graph refused is opened again: a user waits for it after
# correcting the cause.
MAX_RETRY_S = 5.0
# Leaving must not hang on a master that does not answer.
CLOSE_LIMIT_S = 1.0
# Openings and closings of one board at once. Each takes 10 KB: more would fill memory when many boards
# connect or leave together.
CHANGED_AT_ONCE = 4


class EndpointOpenings:
    """Opens and closes the endpoints of one board's node."""

    def __init__(self, notices: Notices) -> None:
        # Why the graph does not have an endpoint that the board has announced.
        self.reasons: dict[Endpoint, str] = {}
        self._notices = notices
        self._opening: dict[Endpoint, asyncio.Task[None]] = {}
        self._closing: dict[Slot, asyncio.Task[None]] = {}
        self._unwanted: set[Endpoint] = set()
        # Refused because of their type: the board may be about to withdraw the other endpoint.
        self._refused: set[Endpoint] = set()
        self._tasks: set[asyncio.Task[None]] = set()
        self._lock = asyncio.Lock()
        self._slots = asyncio.Semaphore(CHANGED_AT_ONCE)

    def open(self, slot: Slot, endpoint: Endpoint) -> None:
        """Open an endpoint in the graph after the earlier endpoints of its slot have left it."""
        self._log(endpoint, "opening")
        self._opening[endpoint] = start_task(
            self._tasks, self._open(endpoint, endpoint.open, self._closing.get(slot))
        )

    def renew(self, endpoint: SubscriberEndpoint) -> None:
        """Subscribe again, unless the endpoint is still being opened."""
        if endpoint not in self._opening:
            self._opening[endpoint] = start_task(self._tasks, self._open(endpoint, endpoint.renew, None))

    def close(self, slot: Slot, endpoint: Endpoint) -> None:
        """Remove an endpoint from the graph."""
        self._log(endpoint, "closing")
        self._unwanted.add(endpoint)
        self._refused.discard(endpoint)
        self.reasons.pop(endpoint, None)
        self._closing[slot] = start_task(self._tasks, self._close(slot, endpoint, self._closing.get(slot)))

    async def finish(self) -> None:
        """Cancel the openings and finish the closings, within a second."""
        for task in self._opening.values():
            task.cancel()
        if self._tasks:
            _, late = await asyncio.wait(list(self._tasks), timeout=CLOSE_LIMIT_S)
            await cancel_all(*late)

    def _log(self, endpoint: Endpoint, state: str) -> None:
        _LOG.debug("%s: %r: %s", self._notices.node, endpoint, state)

    async def _yield_to_loop(self) -> None:
        """Yield to the event loop: many announcements at once must not delay the messages of others."""
        async with self._lock:
            await asyncio.sleep(0)

    async def _open(
        self,
        endpoint: Endpoint,
        open_it: Callable[[], Coroutine[object, object, None]],
        before: asyncio.Task[None] | None,
    ) -> None:
        try:
            if before is not None:
                await asyncio.wait([before])
            await self._keep_opening(endpoint, open_it)
        finally:
            del self._opening[endpoint]

    async def _keep_opening(
        self, endpoint: Endpoint, open_it: Callable[[], Coroutine[object, object, None]]
    ) -> None:
        backoff = Backoff(first_s=0.2, limit_s=MAX_RETRY_S)
        name = name_of(endpoint)
        while True:
            try:
                async with self._slots:
                    await self._yield_to_loop()
                    if endpoint in self._unwanted:
                        return
                    await open_it()
            except (DefinitionError, InvalidNameError, TypeMismatchError) as error:
                if endpoint not in self._unwanted:
                    self._refused.add(endpoint)
                self._log(endpoint, "refused")
                self._report(endpoint, f"{name} is not bridged: {error}", str(error))
                return
            except GraphError as error:
                self._report(endpoint, f"{name} is not bridged yet: {error}; trying again", str(error))
                await asyncio.sleep(backoff.next_delay_s())
            except Exception as error:  # noqa: BLE001 - the other endpoints continue
                reason = reason_of(error)
                self._report(endpoint, f"{name} is not bridged: {reason}", reason)
                return
            else:
                self._notices.end_episode(f"refused {name}")
                self.reasons.pop(endpoint, None)
                self._log(endpoint, "open")
                return

    def _report(self, endpoint: Endpoint, text: str, reason: str) -> None:
        if endpoint not in self._unwanted:
            self.reasons[endpoint] = reason
        self._notices.report_episode(f"refused {name_of(endpoint)}", Level.ERROR, text)

    async def _close(self, slot: Slot, endpoint: Endpoint, before: asyncio.Task[None] | None) -> None:
        try:
            if before is not None:
                await asyncio.wait([before])
            opening = self._opening.get(endpoint)
            if opening is not None:
                await asyncio.wait([opening])
            async with self._slots:
                await self._yield_to_loop()
                await endpoint.close()
            self._log(endpoint, "closed")
        except Exception as error:  # noqa: BLE001 - callers that wait for this closing continue
            self._notices.report_episode(
                "withdraw", Level.WARN, f"{name_of(endpoint)} may still be listed: {reason_of(error)}"
            )
        finally:
            self._unwanted.discard(endpoint)
            if self._closing.get(slot) is asyncio.current_task():
                del self._closing[slot]
        self._open_refused()

    def _open_refused(self) -> None:
        """Retry refused endpoints after one has left the graph: it may have been the reason."""
        refused, self._refused = self._refused, set()
        for endpoint in refused:
            self._opening[endpoint] = start_task(self._tasks, self._open_again(endpoint))

    async def _open_again(self, endpoint: Endpoint) -> None:
        await self._open(endpoint, endpoint.open, None)
        if endpoint not in self._refused and endpoint not in self._unwanted:
            self._notices.report(Level.INFO, f"{name_of(endpoint)} is bridged now")


def name_of(endpoint: Endpoint) -> str:
    """Return the name in the board's announcement."""
    return endpoint.info.name if isinstance(endpoint.info, ServiceAnnounced) else endpoint.info.topic_name

"""The puts of one publication while links are full, in a thread, so that nothing else is delayed.

States and transitions:

    idle         the owner puts messages        -- a batch is not finished -->                busy
                                                -- a very long put, or two long ones -->      cautious
    busy         a thread puts the queue        -- the queue is empty -->                     idle or cautious
    cautious     as busy: the link may be       -- a minute without such a put -->            idle
                 full again at any time

Only the duration of a put shows whether a link has room. If the link is full, zenoh waits for
`WAIT_BEFORE_DROP_US`, and then drops the message. So a subscriber that hangs costs the loop one such wait per
minute.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Executor

from msgspec import Struct

from rostether.errors import SerializationError
from rostether.graph.flow_control import PublicationFlow, SubscriberFlow

# The size of a batch in the thread, the same as zenoh's. The queue can drop only messages that are not yet in
# a batch.
BATCH_BYTES = 64 << 10

# A put that takes this long has waited for a link; the scheduler alone does not cause it.
VERY_LONG_NS = 50_000_000

# A put that takes this long in the loop delays other messages.
LONG_NS = 10_000_000

# Two such puts within this time are not a coincidence.
LONG_AGAIN_S = 2.0

# How long the thread is used after a put that would have blocked the loop.
THREAD_IN_USE_S = 60.0

# How long a closing publication waits for its remaining puts; a subscriber that hangs must not delay it more.
FINISH_LIMIT_S = 1.0

_log = logging.getLogger("rostether.ros2")


class BatchResult(Struct):
    """The result of a batch: `done` messages are finished, the others were not started.

    `misfits` of them did not fit their type; `error` is the reason for the last one. Zenoh dropped `lost` of
    them. The longest put took `longest_ns`.
    """

    done: int = 0
    misfits: int = 0
    lost: int = 0
    longest_ns: int = 0
    error: SerializationError | None = None


class PutQueue:
    """Puts added messages in a thread, in order; drops the oldest beyond `limit_bytes`.

    `put` is called in a thread, never twice at once; `note` is called in the loop with the result.
    """

    def __init__(
        self,
        put: Callable[[Sequence[bytes]], BatchResult],
        note: Callable[[BatchResult], None],
        threads: Executor,
        limit_bytes: int,
    ) -> None:
        # Whether nothing waits here, so that new messages may be put immediately.
        self.is_idle = True
        self.dropped_count = 0
        self.flow = PublicationFlow()
        self._put = put
        self._note = note
        self._threads = threads
        self._limit_bytes = limit_bytes
        self._waiting: deque[bytes] = deque()
        self._waiting_bytes = 0
        self._backlog = SubscriberFlow(self.flow, lambda: self._waiting_bytes, limit_bytes)
        self._job: asyncio.Future[BatchResult] | None = None
        self._thread_timer: asyncio.TimerHandle | None = None
        self._long_s = float("-inf")
        self._has_ended = False

    def add(self, payloads: Sequence[bytes]) -> None:
        """Queue messages."""
        self.is_idle = False
        self._waiting.extend(payloads)
        self._waiting_bytes += sum(map(len, payloads))
        while self._waiting_bytes > self._limit_bytes and len(self._waiting) > 1:
            self._waiting_bytes -= len(self._waiting.popleft())
            self.dropped_count += 1
        self._backlog.update()
        if self._job is None:
            self._continue()

    def note_longest(self, longest_ns: int) -> None:
        """Record the longest put of a batch: after long puts, the thread is used for `THREAD_IN_USE_S`."""
        if longest_ns < LONG_NS:
            return
        loop = asyncio.get_running_loop()
        is_again = loop.time() - self._long_s < LONG_AGAIN_S
        self._long_s = loop.time()
        if is_again or longest_ns >= VERY_LONG_NS:
            self.is_idle = False
            if self._thread_timer is not None:
                self._thread_timer.cancel()
            self._thread_timer = loop.call_later(THREAD_IN_USE_S, self._leave_thread)

    async def finish(self) -> None:
        """Put the waiting messages within `FINISH_LIMIT_S`; drop the rest."""
        try:
            async with asyncio.timeout(FINISH_LIMIT_S):
                while self._job is not None:
                    await asyncio.wait([self._job])
                    # Let the loop call `_job_done`, which may start the next job.
                    await asyncio.sleep(0)
        except TimeoutError:
            _log.debug("%d messages were dropped because a link is full", len(self._waiting))
        finally:
            self._has_ended = True
            self.dropped_count += len(self._waiting)
            self._waiting.clear()
            self._backlog.end()
            if self._thread_timer is not None:
                self._thread_timer.cancel()

    def _continue(self) -> None:
        batch: list[bytes] = []
        batch_bytes = 0
        while self._waiting and batch_bytes < BATCH_BYTES:
            batch.append(self._waiting.popleft())
            batch_bytes += len(batch[-1])
        self._waiting_bytes -= batch_bytes
        self._backlog.update()
        self._job = asyncio.get_running_loop().run_in_executor(self._threads, self._put, batch)
        self._job.add_done_callback(self._job_done)

    def _job_done(self, job: asyncio.Future[BatchResult]) -> None:
        self._job = None
        if job.cancelled() or job.exception() is not None:
            # The session or the publication has ended in the meantime.
            _log.debug("messages were not sent: %s", "ended" if job.cancelled() else job.exception())
        elif not self._has_ended:
            self._note(job.result())
        if self._has_ended:
            return
        if self._waiting:
            self._backlog.note_sent()
            self._continue()
        elif self._thread_timer is None:
            self.is_idle = True

    def _leave_thread(self) -> None:
        self._thread_timer = None
        self.is_idle = self._job is None

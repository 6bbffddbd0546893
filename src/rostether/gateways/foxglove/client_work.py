"""The running work of one client: tasks that end with it, and a limited number of requests."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Coroutine
from typing import Any

from rostether.errors import RostetherError
from rostether.graph.callbacks import report_error
from rostether.mechanisms.tasks import start_task


class ClientWork:
    """The tasks of one client."""

    def __init__(self) -> None:
        self._tasks: set[asyncio.Task[Any]] = set()
        self._requests: Counter[str] = Counter()

    def start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Run a coroutine as a task; its errors are reported."""
        task = start_task(self._tasks, work)
        task.add_done_callback(_report_failure)
        return task

    def ask(
        self,
        work: Callable[[], Coroutine[Any, Any, None]],
        fail: Callable[[str], None],
        limit: int,
        what: str = "requests",
    ) -> None:
        """Start a request as a task, or refuse it beyond `limit`; its errors are reported in one line."""
        if self._requests[what] >= limit:
            fail(f"more than {limit} {what} at once; wait for the responses")
            return

        async def contained() -> None:
            try:
                await work()
            except RostetherError as error:
                fail(str(error))
            except TimeoutError:
                fail("no answer in time; check that the node is running")

        # Counted immediately: a client may send many requests at a time.
        self._requests[what] += 1
        self.start(contained()).add_done_callback(lambda _: self._requests.subtract([what]))

    def cancel(self) -> None:
        """Cancel all tasks."""
        for task in self._tasks:
            task.cancel()


def _report_failure(task: asyncio.Task[Any]) -> None:
    if not task.cancelled() and (error := task.exception()) is not None:
        report_error("a Foxglove client's request", error)

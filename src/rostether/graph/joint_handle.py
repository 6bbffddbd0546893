"""Opens one handle (a publisher, a subscriber, a service, a watch) in each of several graphs.

A graph that refuses it for now (its master does not answer) is asked again. One that refuses it permanently
(it does not know the type) is omitted. Neither disturbs the others.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Sequence
from functools import partial
from typing import Any, Generic, TypeAlias, TypeVar

from rostether.errors import AccessDeniedError, GraphError, RostetherError, TypeMismatchError
from rostether.graph.ports import Graph
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.block_end import Closable
from rostether.mechanisms.tasks import start_task

# Many failures are short, for example while a master restarts.
FIRST_RETRY_S = 0.2
# A graph that is unreachable returns within seconds, or much later: then this rate is sufficient.
MAX_RETRY_S = 5.0

# How long a hanging graph may delay the others; it continues to open in the background.
SLOW_GRAPH_S = 1.0

_log = logging.getLogger("rostether.graph")

PartT = TypeVar("PartT", bound=Closable)
_Trial: TypeAlias = "asyncio.Task[RostetherError | None]"


class JointHandle(Generic[PartT]):
    """One handle in several graphs: `parts` are the handles that are open, by graph.

    `open_in` opens the handle in one graph.
    """

    def __init__(self, what: str, open_in: Callable[[Graph], Awaitable[PartT]]) -> None:
        self.parts: dict[Graph, PartT] = {}
        self.is_closed = False
        self._what = what
        self._open_in = open_in
        self._tasks: set[asyncio.Task[Any]] = set()

    async def open(self, graphs: Sequence[Graph]) -> None:
        """Open the handle in every graph that accepts it. Raises the graphs' errors if none does."""
        trials = {start_task(self._tasks, self._try(graph)): graph for graph in graphs}
        try:
            await self._wait(trials)
        except BaseException:
            await self.close()
            raise
        if not self.parts:
            faults = [fault for trial in trials if (fault := trial.result()) is not None]
            raise min(faults, key=_rank)
        for trial, graph in trials.items():
            if trial.done():
                self._note(graph, trial)
            else:
                trial.add_done_callback(partial(self._note, graph))

    async def add(self, graph: Graph) -> None:
        """Open the handle in another graph."""
        trial = start_task(self._tasks, self._try(graph))
        trial.add_done_callback(partial(self._note, graph))
        await asyncio.wait((trial,))

    async def close(self) -> None:
        """Close the handle in all graphs. Idempotent. Raises the first error after all were closed."""
        self.stop()
        parts = list(self.parts.values())
        self.parts.clear()
        results = await asyncio.gather(*(part.close() for part in parts), return_exceptions=True)
        for result in results:
            if isinstance(result, BaseException):
                raise result

    def stop(self) -> None:
        """Stop opening the handle in further graphs; the open parts end with their graphs."""
        self.is_closed = True
        for task in self._tasks:
            task.cancel()

    async def _wait(self, trials: dict[_Trial, Graph]) -> None:
        """Wait for all attempts, but only briefly for one that hangs after another has succeeded."""
        pending = set(trials)
        while pending:
            done, pending = await asyncio.wait(
                pending, timeout=SLOW_GRAPH_S if self.parts else None, return_when=asyncio.FIRST_COMPLETED
            )
            if not done:
                return

    async def _try(self, graph: Graph) -> RostetherError | None:
        try:
            part = await self._open_in(graph)
        except RostetherError as error:
            return error
        if self.is_closed:
            await part.close()
        else:
            self.parts[graph] = part
        return None

    def _note(self, graph: Graph, trial: _Trial) -> None:
        if trial.cancelled() or self.is_closed:
            return
        fault = trial.result()
        if fault is not None:
            self._warn(graph, fault)
            if _is_temporary(fault):
                start_task(self._tasks, self._keep_trying(graph))

    async def _keep_trying(self, graph: Graph) -> None:
        backoff = retry_backoff()
        while True:
            await asyncio.sleep(backoff.next_delay_s())
            fault = await self._try(graph)
            if fault is None:
                return
            if not _is_temporary(fault):
                self._warn(graph, fault)
                return

    def _warn(self, graph: Graph, fault: RostetherError) -> None:
        yet = " yet" if _is_temporary(fault) else ""
        _log.warning("%s: %s is not in every graph%s: %s", graph.node_name, self._what, yet, fault)


def retry_backoff() -> Backoff:
    """Return the delays between attempts to reach a graph."""
    return Backoff(first_s=FIRST_RETRY_S, limit_s=MAX_RETRY_S)


def _rank(fault: RostetherError) -> int:
    """Return the order of reports: own errors first, then failures worth a retry."""
    return 0 if isinstance(fault, TypeMismatchError) else 1 if _is_temporary(fault) else 2


def _is_temporary(fault: RostetherError) -> bool:
    return isinstance(fault, GraphError) and not isinstance(fault, TypeMismatchError | AccessDeniedError)

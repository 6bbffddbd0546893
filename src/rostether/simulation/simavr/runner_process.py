"""The process of the runner: commands in, events out."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self, TypeVar

from rostether.errors import BoardError
from rostether.mechanisms.program import wait_or_kill
from rostether.simulation.simavr.board_events import BoardEvent, parse_event

T = TypeVar("T")

# Much longer than the longest event (4096 bytes of memory in hexadecimal).
MAX_LINE_BYTES = 1 << 18
# The runner starts and answers within milliseconds on an idle machine.
START_LIMIT_S = 20.0
ANSWER_LIMIT_S = 20.0
# The runner leaves its loop within a millisecond; after this time, it is killed.
END_LIMIT_S = 2.0


class RunnerProcess:
    """The process of one runner; `on_event` gets each event except the answers to `send_command`."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self.on_event: Callable[[BoardEvent], None] = lambda _event: None
        self._process = process
        self._numbers = itertools.count(1)
        self._answers: dict[int, asyncio.Future[BoardEvent]] = {}
        self._failure = ""
        self._reading: asyncio.Task[None] | None = None

    @classmethod
    async def start(cls, program: Path, arguments: Sequence[str]) -> tuple[Self, list[BoardEvent]]:
        """Start a runner; return it with its first events: "ready" and the results of its first commands.

        Raises BoardError if it does not start in time, or with the reason that it reports.
        """
        process = await asyncio.create_subprocess_exec(
            str(program),
            *arguments,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
            limit=MAX_LINE_BYTES,
        )
        made = cls(process)
        try:
            async with asyncio.timeout(START_LIMIT_S):
                events = await made._first_events()
        except BaseException as error:
            await made.close()
            if isinstance(error, TimeoutError):
                raise BoardError(
                    f"the simulated board did not start within {START_LIMIT_S:g} s; try again on an "
                    "idle computer"
                ) from None
            raise
        made._reading = asyncio.get_running_loop().create_task(made._read())
        return made, events

    @property
    def has_ended(self) -> bool:
        """Whether the process has ended."""
        return self._reading is None or self._reading.done()

    @property
    def exit_code(self) -> int | None:
        """The exit code; None while it runs, negative for a signal."""
        return self._process.returncode

    async def send_command(self, line: str) -> None:
        """Send a command, and wait until it is done. Raises BoardError with its error."""
        if "\n" in line:
            raise BoardError("a command for a simulated board must be one line")
        number = next(self._numbers)
        answer: asyncio.Future[BoardEvent] = asyncio.get_running_loop().create_future()
        self._answers[number] = answer
        try:
            stdin = self._process.stdin
            assert stdin is not None
            with contextlib.suppress(ConnectionError):
                stdin.write(f"#{number} {line}\n".encode())
                await stdin.drain()
            event = await self.wait_before_end(answer, f"answer to {line!r}", ANSWER_LIMIT_S)
        finally:
            del self._answers[number]
        if event.name == "error":
            raise BoardError(f"{line}: {event['text']}")

    async def wait_before_end(self, found: asyncio.Future[T], what: str, timeout_s: float) -> T:
        """Return the result of a future; `what` names it in errors.

        Raises BoardError if the process ends or the time is over first.
        """
        reading = self._reading
        waited = {found} if reading is None else {found, reading}
        await asyncio.wait(waited, timeout=timeout_s, return_when=asyncio.FIRST_COMPLETED)  # type: ignore[type-var]
        if found.done():
            return found.result()
        found.cancel()
        if self.has_ended:
            raise BoardError(f"the simulated board has ended{f': {self._failure}' if self._failure else ''}")
        raise BoardError(f"the simulated board sent no {what} within {timeout_s:g} s")

    async def wait_end(self) -> None:
        """Wait until the runner has ended."""
        if self._reading is not None:
            await asyncio.shield(self._reading)
        await self._process.wait()

    async def close(self) -> None:
        """End the runner, and wait for its end."""
        process = self._process
        assert process.stdin is not None
        process.stdin.close()
        try:
            await wait_or_kill(process, END_LIMIT_S)
        finally:
            if self._reading is not None:
                await asyncio.gather(self._reading, return_exceptions=True)
            with contextlib.suppress(ConnectionError):
                await process.stdin.wait_closed()

    async def _first_events(self) -> list[BoardEvent]:
        events: list[BoardEvent] = []
        while not any(event.name == "reset" for event in events):
            line = await self._next_line()
            if not line:
                raise BoardError("the simulated board ended at its start")
            event = parse_event(line)
            if event.name == "failed":
                raise BoardError(event["text"])
            events.append(event)
        return events

    async def _next_line(self) -> bytes:
        assert self._process.stdout is not None
        try:
            return await self._process.stdout.readline()
        except ValueError:
            raise BoardError("the simulated board's runner printed a line that is too long") from None

    async def _read(self) -> None:
        try:
            while line := await self._next_line():
                event = parse_event(line)
                answer = self._answers.get(event.values.get("id", 0))
                if answer is not None and event.name in ("done", "error"):
                    if not answer.done():
                        answer.set_result(event)
                    continue
                self.on_event(event)
        except BoardError as error:
            self._failure = str(error)
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()

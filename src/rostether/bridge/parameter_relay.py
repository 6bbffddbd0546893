"""Answers all parameter requests of a board in order: the sketch waits for each answer."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Callable

from rostether.bridge.reporter import Notices, reason_of
from rostether.bridge.settings import BridgeSettings
from rostether.errors import GraphError, LocalProtocolError, TypeMismatchError, UnknownNameError
from rostether.graph.ports import Graph, Level, ParamValue
from rostether.ports.settings import ANY_ACCESS, Access
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import ParameterResponse

# A board waits for each answer before its next request, so more than a few waiting requests are damage.
MAX_WAITING = 16
# The pause before a master that did not answer is asked again, while the board still waits.
RETRY_S = 0.1

_FLOAT32_MAX = 3.4028234663852886e38
_INT32_MIN, _INT32_MAX = -(2**31), 2**31 - 1


def to_answer(value: ParamValue) -> ParameterResponse | None:
    """Return a value as a board can receive it; None for mappings, mixed lists and huge integers."""
    items = value if isinstance(value, list) else [value]
    if all(isinstance(item, int) for item in items):
        ints = tuple(int(item) for item in items if isinstance(item, int))
        fit = all(_INT32_MIN <= item <= _INT32_MAX for item in ints)
        return ParameterResponse(ints=ints) if fit else None
    if all(isinstance(item, int | float) and not isinstance(item, bool) for item in items):
        floats = tuple(float(item) for item in items if isinstance(item, int | float))
        fit = all(abs(item) <= _FLOAT32_MAX or not math.isfinite(item) for item in floats)
        return ParameterResponse(floats=floats) if fit else None
    if all(isinstance(item, str) for item in items):
        return ParameterResponse(strings=tuple(item for item in items if isinstance(item, str)))
    return None


class ParameterRelay:
    """Answers the parameter requests of one session; `on_answered` sends the link's waiting frames."""

    def __init__(
        self,
        link: HostLink,
        graph: Graph,
        notices: Notices,
        settings: BridgeSettings,
        on_answered: Callable[[], None],
        access: Access = ANY_ACCESS,
    ) -> None:
        self._link = link
        self._graph = graph
        self._notices = notices
        self._settings = settings
        self._access = access
        self._names: deque[str] = deque()
        self._working: asyncio.Task[None] | None = None
        self._on_answered = on_answered

    def ask(self, name: str) -> None:
        """Handle a parameter request of the board."""
        if len(self._names) >= MAX_WAITING:
            self._notices.report_episode(
                "parameters",
                Level.WARN,
                f"too many parameter requests at once; {name} gets no answer; request one after the other",
            )
            return
        self._names.append(name)
        if self._working is None:
            self._working = asyncio.get_running_loop().create_task(self._work())

    def close(self) -> None:
        """Cancel all requests, because the board has disconnected."""
        self._names.clear()
        if self._working is not None:
            self._working.cancel()
            self._working = None

    async def _work(self) -> None:
        while self._names:
            name = self._names[0]
            try:
                answer = await self._find(name)
            except Exception as error:  # noqa: BLE001 - the board waits, and asks again
                self._report(name, reason_of(error))
                answer = ParameterResponse()
            self._names.popleft()
            self._send(name, answer)
            self._on_answered()
        self._working = None

    def _send(self, name: str, answer: ParameterResponse) -> None:
        try:
            self._link.answer_parameter(*answer)
        except Exception as error:  # noqa: BLE001 - as above
            reason, outcome = reason_of(error), "the board gets an empty answer"
            try:
                self._link.answer_parameter()
            except LocalProtocolError:
                outcome = (
                    "even an empty answer does not fit; enlarge the input buffer of the sketch's NodeHandle_"
                )
            self._report(name, f"{reason}; {outcome}")

    async def _find(self, name: str) -> ParameterResponse:
        """Return the answer. Raises GraphError, InvalidNameError with the reason why there is none."""
        if self._access is not ANY_ACCESS:
            self._access.check("parameters", self._graph.resolve(name))
        timeout_s = self._settings.parameter_timeout_s
        failure = f"no answer from the master within {timeout_s:g} s"
        try:
            async with asyncio.timeout(timeout_s):
                while True:
                    try:
                        value = await self._graph.get_param(name)
                        break
                    except UnknownNameError:
                        raise UnknownNameError("it is not set") from None
                    except GraphError as error:
                        failure = str(error)
                        await asyncio.sleep(RETRY_S)
        except TimeoutError:
            raise GraphError(failure) from None
        if (answer := to_answer(value)) is None:
            raise TypeMismatchError(
                "a board can read a 32-bit integer, a float, a string, a bool or a list of one of these, "
                f"but this is {_describe(value)}"
            )
        return answer

    def _report(self, name: str, reason: str) -> None:
        self._notices.report_episode(
            f"parameter {name[:80]}", Level.WARN, f"parameter {name}, requested by the board: {reason}"
        )


def _describe(value: ParamValue) -> str:
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return "a list of other or mixed types"
    return "a number outside these ranges" if isinstance(value, int | float) else "binary data"

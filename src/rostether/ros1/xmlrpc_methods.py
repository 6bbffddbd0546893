"""The methods of an XML-RPC server: a request's document in, the response's document out.

A method is any callable of XML-RPC values, plain or async. Its errors become answers without a traceback: the
answer to a RostetherError is its text. For any other error it is a fault that names the error, and the error
is also logged.
"""

from __future__ import annotations

import asyncio
import inspect
import logging
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from time import monotonic
from typing import Any, TypeAlias

from rostether.errors import RemoteProtocolError, RostetherError, SerializationError
from rostether.ros1.long_work import RUNNING_AT_ONCE, SLICE_S, run_in_slices
from rostether.xmlrpc.document_reader import DocumentReader, load_call
from rostether.xmlrpc.document_writer import (
    DocumentTooLargeError,
    DocumentWriter,
    dump_fault,
    dump_response,
    fault,
    response_steps,
)
from rostether.xmlrpc.values import FaultError, XmlRpcValue

Method: TypeAlias = Callable[..., Any]
Dispatch: TypeAlias = Mapping[str, Method]

# A multicall sets the parameters of one launch file; a larger one would delay all other clients.
MAX_MULTICALL = 10_000
# A document of this size takes half a millisecond; longer ones are read in slices. Registrations have about
# 700 bytes.
AT_ONCE_BYTES = 4 * 1024
_MULTICALL = "system.multicall"
_FAULT = 1

_log = logging.getLogger("rostether.ros1.xmlrpc")


class MethodTable:
    """The methods of `dispatch`, `system.multicall` and `system.listMethods`.

    Answers have at most `answer_bytes`. Long documents are read and written in slices, so that the event loop
    serves others in the meantime.
    """

    def __init__(self, dispatch: Dispatch, answer_bytes: int) -> None:
        self._methods: dict[str, Method] = {
            **dispatch,
            "system.listMethods": lambda: sorted([*self._methods, _MULTICALL]),
        }
        self._answer_bytes = answer_bytes
        self._long_work = asyncio.Semaphore(RUNNING_AT_ONCE)

    def answer(self, document: bytes) -> bytes | Awaitable[bytes]:
        """Return the response document, directly if it is small and the method is not a coroutine."""
        if len(document) > AT_ONCE_BYTES:
            return self._answer_large(document)
        try:
            method, params = load_call(document)
        except RemoteProtocolError as error:
            return dump_fault(_FAULT, str(error))
        return self._respond(method, params)

    async def _answer_large(self, document: bytes) -> bytes:
        reader = DocumentReader(document)
        try:
            async with self._long_work:
                await run_in_slices(reader.steps())
            method, params = reader.call()
        except RemoteProtocolError as error:
            return dump_fault(_FAULT, str(error))
        answer = self._respond(method, params)
        return answer if isinstance(answer, bytes) else await answer

    def _respond(self, method: str, params: Sequence[XmlRpcValue]) -> bytes | Awaitable[bytes]:
        if method == _MULTICALL:
            return self._multicall(params)
        try:
            value = self._call(method, params)
        except Exception as error:  # noqa: BLE001 - whatever a peer provokes must not stop the server
            return _dump_error(method, error)
        if inspect.isawaitable(value):
            return self._respond_later(method, value)
        return self._write(method, value)

    async def _respond_later(self, method: str, value: Awaitable[object]) -> bytes:
        try:
            answer = self._write(method, await value)
        except Exception as error:  # noqa: BLE001
            return _dump_error(method, error)
        return answer if isinstance(answer, bytes) else await answer

    def _write(self, method: str, value: object) -> bytes | Awaitable[bytes]:
        writer = DocumentWriter(self._answer_bytes)
        steps = response_steps(writer, value)
        try:
            for _ in steps:
                return self._write_rest(method, writer, steps)
            return writer.document()
        except SerializationError as error:
            return self._dump_unwritable(method, error)

    async def _write_rest(self, method: str, writer: DocumentWriter, steps: Iterator[None]) -> bytes:
        try:
            async with self._long_work:
                await run_in_slices(steps)
            return writer.document()
        except SerializationError as error:
            return self._dump_unwritable(method, error)

    def _dump_unwritable(self, method: str, error: SerializationError) -> bytes:
        if isinstance(error, DocumentTooLargeError):
            return dump_fault(
                _FAULT,
                f"the answer of {method} would need more than {self._answer_bytes} bytes; request less at a"
                " time, or raise --limit xmlrpc-bytes of the server",
            )
        return _dump_error(method, error)

    def _call(self, method: str, params: Sequence[XmlRpcValue]) -> Any:
        function = self._methods.get(method)
        if function is None:
            raise FaultError(_FAULT, f'method "{method:.200}" is not supported')
        return function(*params)

    async def _multicall(self, params: Sequence[XmlRpcValue]) -> bytes:
        calls = params[0] if len(params) == 1 else None
        if not isinstance(calls, list) or len(calls) > MAX_MULTICALL:
            return dump_fault(_FAULT, f"{_MULTICALL} needs an array of at most {MAX_MULTICALL} calls")
        writer = DocumentWriter(self._answer_bytes)
        try:
            async with self._long_work:
                await self._write_multicall(writer, calls)
            return writer.document()
        except DocumentTooLargeError as error:
            return self._dump_unwritable(_MULTICALL, error)

    async def _write_multicall(self, writer: DocumentWriter, calls: Sequence[XmlRpcValue]) -> None:
        due_s = monotonic() + SLICE_S
        writer.begin_response_array()
        for call in calls:
            start = writer.mark()
            try:
                await run_in_slices(writer.value_steps([await self._call_one(call)]))
            except DocumentTooLargeError:
                raise
            except Exception as error:  # noqa: BLE001
                writer.rewind(start)
                writer.write_value(fault(_FAULT, _explain(_MULTICALL, error)))
            if monotonic() >= due_s:
                await asyncio.sleep(0)
                due_s = monotonic() + SLICE_S
        writer.end_response_array()

    async def _call_one(self, call: XmlRpcValue) -> Any:
        method = call.get("methodName") if isinstance(call, dict) else None
        params = call.get("params", []) if isinstance(call, dict) else None
        if not isinstance(method, str) or not isinstance(params, list):
            raise FaultError(_FAULT, f"{_MULTICALL} needs structs of methodName and params")
        if method == _MULTICALL:
            raise FaultError(_FAULT, f"{_MULTICALL} inside {_MULTICALL} is forbidden")
        try:
            value = self._call(method, params)
            return await value if inspect.isawaitable(value) else value
        except Exception as error:
            raise FaultError(_FAULT, _explain(method, error)) from error


def _dump_error(method: str, error: Exception) -> bytes:
    if isinstance(error, RostetherError) and not isinstance(error, (FaultError, SerializationError)):
        return dump_response([-1, _explain(method, error), 0])
    return dump_fault(_FAULT, _explain(method, error))


def _explain(method: str, error: Exception) -> str:
    if isinstance(error, RostetherError):
        return str(error)
    if isinstance(error, TypeError):
        # Nearly always the wrong number of arguments.
        return f"{method}: bad arguments: {error}"
    _log.error("%s failed: %s: %s", method, type(error).__name__, error)
    return f"{method} failed: {type(error).__name__}: {error}"

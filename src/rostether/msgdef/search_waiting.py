"""Searches folders of definitions in a thread, so that the event loop is not blocked."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar
from weakref import WeakKeyDictionary

from rostether.msgdef.registry import Registry

_T = TypeVar("_T")

_searches: WeakKeyDictionary[Registry, Future[None]] = WeakKeyDictionary()


def start_search(registry: Registry) -> Future[None]:
    """Search all folders of a registry in a thread, once. After that, the registry searches no folders."""
    search = _searches.get(registry)
    if search is None:
        search = _searches[registry] = Future()
        # It cannot be canceled, because several callers may wait for it.
        search.set_running_or_notify_cancel()
        # A daemon thread: the end of the program must not wait for a search.
        threading.Thread(target=_run, args=(registry, search), name="definitions", daemon=True).start()
    return search


async def definitions_searched(registry: Registry) -> None:
    """Wait until all folders of definitions have been searched."""
    await wait_for_definitions(registry, registry.packages)


async def wait_for_definitions(registry: Registry, query: Callable[[], _T]) -> _T:
    """Return the answer of a query, as soon as it needs no search of folders; usually that is immediately.

    Raises the errors of the query.
    """
    if not registry.can_answer(query):
        await asyncio.wrap_future(start_search(registry))
    return query()


def _run(registry: Registry, search: Future[None]) -> None:
    try:
        registry.search()
    except Exception as error:  # noqa: BLE001 - the waiting callers raise it
        search.set_exception(error)
    else:
        search.set_result(None)

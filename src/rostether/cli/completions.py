"""What a shell can complete: names in the running graph, and types that are known here."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from typing import TYPE_CHECKING

import click

from rostether.errors import RostetherError

if TYPE_CHECKING:
    from rostether.ros1.node.master_client import MasterClient

TIMEOUT_S = 1.0
"""Who presses Tab waits no longer; a master on this machine answers in milliseconds."""


def complete_topics(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the topics that begin with what was typed."""

    async def names(client: MasterClient) -> Iterable[str]:
        publishers, subscribers, _ = await client.system_state()
        return publishers.keys() | subscribers.keys()

    return _complete(names, incomplete)


def complete_nodes(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the nodes that begin with what was typed."""

    async def names(client: MasterClient) -> Iterable[str]:
        return {node for part in await client.system_state() for nodes in part.values() for node in nodes}

    return _complete(names, incomplete)


def complete_services(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the services that begin with what was typed."""

    async def names(client: MasterClient) -> Iterable[str]:
        return (await client.system_state())[2]

    return _complete(names, incomplete)


def complete_params(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the parameters that begin with what was typed."""

    async def names(client: MasterClient) -> Iterable[str]:
        return await client.param_names()

    return _complete(names, incomplete)


def complete_message_types(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the message types that begin with what was typed."""
    from rostether.msgdef.registry import Registry

    return _beginning(Registry.from_environment().messages(), incomplete)


def complete_service_types(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the service types that begin with what was typed."""
    from rostether.msgdef.registry import Registry

    return _beginning(Registry.from_environment().services(), incomplete)


def complete_packages(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Return the packages that have definitions and begin with what was typed."""
    from rostether.msgdef.registry import Registry

    return _beginning(Registry.from_environment().packages(), incomplete)


def _complete(names: Callable[[MasterClient], Awaitable[Iterable[str]]], incomplete: str) -> list[str]:
    # Not at import: it takes a quarter of a command's start, and not all commands need it.
    import asyncio

    from rostether.cli.graph_access import master_client, read_environment

    async def ask() -> Iterable[str]:
        async with asyncio.timeout(TIMEOUT_S), master_client(read_environment()) as client:
            return await names(client)

    try:
        return _beginning(asyncio.run(ask()), incomplete)
    except (RostetherError, OSError):
        # A shell has no place for errors: there is nothing to complete.
        return []


def _beginning(names: Iterable[str], incomplete: str) -> list[str]:
    # `chatter` stands for `/chatter` in commands, so it completes to it as well.
    return sorted(name for name in names if name.startswith((incomplete, f"/{incomplete}")))

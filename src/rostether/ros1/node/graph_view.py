"""Snapshots of the whole graph from the master, now and after each change.

A ROS 1 master does not report changes: it is polled.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from msgspec.structs import replace

from rostether.errors import MasterUnreachableError
from rostether.graph.ports import ServiceEntry, Snapshot, TopicEntry
from rostether.graph.snapshots import poll_snapshots
from rostether.msgdef.interface import ANY_TYPE
from rostether.ros1.node.master_client import MasterClient

# Users would not notice a shorter delay; two small calls a second do not load a master.
POLL_INTERVAL_S = 1.0


async def take_snapshot(master: MasterClient) -> Snapshot:
    """Request the whole graph from the master. Raises MasterUnreachableError, GraphError."""
    (publishers, subscribers, services), types = await asyncio.gather(
        master.system_state(), master.topic_types()
    )
    nodes: set[str] = set()
    for table in (publishers, subscribers, services):
        nodes.update(*table.values())
    return Snapshot(
        nodes=tuple(sorted(nodes)),
        topics={
            name: TopicEntry(
                name,
                types.get(name, ANY_TYPE),
                tuple(sorted(publishers.get(name, ()))),
                tuple(sorted(subscribers.get(name, ()))),
            )
            for name in sorted(publishers.keys() | subscribers.keys())
        },
        services={
            name: ServiceEntry(name, tuple(sorted(providers))) for name, providers in sorted(services.items())
        },
    )


def watch_changes(master: MasterClient, closed: asyncio.Event) -> AsyncIterator[Snapshot]:
    """Yield a snapshot now and one after each change, until `closed` is set.

    If the master is unreachable later, the snapshot's `problem` has the reason; only the first request
    raises MasterUnreachableError. Raises GraphError if the master refuses a request.
    """
    latest: Snapshot | None = None

    async def take() -> Snapshot:
        nonlocal latest
        try:
            latest = await take_snapshot(master)
        except MasterUnreachableError as error:
            if latest is None:
                raise
            if not latest.problem:
                latest = replace(latest, problem=str(error))
        return latest

    return poll_snapshots(take, closed, POLL_INTERVAL_S)

"""Drives robots for web clients: the node `web_teleop` publishes their commands, limited, under a lease."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Hashable
from contextlib import suppress
from typing import Protocol

from rostether.errors import ConfigError, RostetherError, TypeMismatchError
from rostether.gateways.teleop.command_lease import CommandLease
from rostether.gateways.teleop.drive_commands import DRIVE_TYPES, DriveCommands, DriveLimits
from rostether.graph.callbacks import report_error
from rostether.graph.ports import Graph, Publisher
from rostether.msgdef.interface import MessageType
from rostether.serde.codec import Codec
from rostether.serde.values import Message

# Command topics of all clients together; a robot has one or two.
MAX_TOPICS = 32


class Driver(Hashable, Protocol):
    """A client that wants to drive; `name` is its display name."""

    name: str

    def lease_changed(self, holder: str) -> None:
        """Report the name of the current driver, an empty string if there is none."""

    def ended(self, reason: str) -> None:
        """Report that the topic can no longer be driven, and why."""


class CommandTopic:
    """One topic that clients drive; made by `Teleop`."""

    def __init__(self, publisher: Publisher, codec: Codec, commands: DriveCommands) -> None:
        self.users: set[Driver] = set()
        self.commands = commands
        self._publisher = publisher
        self._codec = codec
        self._lease = CommandLease[Driver]()
        self._reported: Driver | None = None
        self._last: Message | None = None
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None

    @property
    def type(self) -> MessageType:
        """The type of the commands."""
        return self._publisher.type

    @property
    def holder(self) -> str:
        """The name of the current driver, an empty string if there is none."""
        return self._lease.driver.name if self._lease.driver is not None else ""

    def is_stop(self, payload: bytes) -> bool:
        """Return whether a command is a stop. Raises RostetherError."""
        return self.commands.is_stop(self._codec.decode(payload))

    def command(self, driver: Driver, payload: bytes) -> bool:
        """Publish a command; return whether the driver may drive. Raises RostetherError."""
        message = self._codec.decode(payload)
        now_s = self._loop.time()
        if not self._lease.admits(driver, now_s, is_stop=self.commands.is_stop(message)):
            return False
        is_stop = self.commands.limit(message, now_s)
        self._lease.command(driver, now_s, is_stop=is_stop)
        self._last = message
        self._publisher.publish_raw([self._codec.encode(message)])
        self._update()
        return True

    def leave(self, driver: Driver) -> None:
        """Remove a driver, and stop the robot if this driver moved it."""
        self.users.discard(driver)
        if self._lease.release(driver):
            self._stop()
        self._update()

    async def close(self) -> None:
        """Stop, and unadvertise."""
        if self._timer is not None:
            self._timer.cancel()
        if self._lease.driver is not None:
            self.leave(self._lease.driver)
        await self._publisher.close()

    def end(self, reason: str) -> None:
        """Drop everything: the node has left the graph."""
        if self._timer is not None:
            self._timer.cancel()
        users = list(self.users)
        self.users.clear()
        for user in users:
            user.ended(reason)

    def _expire(self) -> None:
        self._timer = None
        if self._lease.expire(self._loop.time()):
            self._stop()
        self._update()

    def _stop(self) -> None:
        if self._last is None:
            return
        self.commands.stop(self._last)
        try:
            self._publisher.publish_raw([self._codec.encode(self._last)])
        except RostetherError as error:
            report_error(f"the stop on {self._publisher.topic}", error)

    def _update(self) -> None:
        """Report a new driver to all, and schedule the next expiry."""
        if self._lease.driver is not self._reported:
            self._reported = self._lease.driver
            for user in list(self.users):
                user.lease_changed(self.holder)
        due_s = self._lease.due_s
        if self._timer is not None:
            if due_s is not None and self._timer.when() <= due_s:
                # The timer checks the deadline when it fires: cheaper than a new timer for each command.
                return
            self._timer.cancel()
            self._timer = None
        if due_s is not None:
            self._timer = self._loop.call_at(due_s, self._expire)


class Teleop:
    """The command topics of one gateway; `join` makes their node when the first is driven."""

    def __init__(self, join: Callable[[], Awaitable[Graph]]) -> None:
        self._join = join
        self._graph: Graph | None = None
        self._topics: dict[str, CommandTopic] = {}
        self._lock = asyncio.Lock()
        self._watching: asyncio.Task[None] | None = None

    async def enter(
        self, driver: Driver, topic: str, message_type: MessageType, codec: Codec
    ) -> CommandTopic:
        """Return a topic for a driver, which must leave it. Raises RostetherError."""
        if message_type.name not in DRIVE_TYPES:
            raise ConfigError(f"only {', '.join(DRIVE_TYPES)} can be driven, not {message_type.name[:80]}")
        async with self._lock:
            found = self._topics.get(topic)
            if found is None:
                if len(self._topics) >= MAX_TOPICS:
                    raise ConfigError(
                        f"at most {MAX_TOPICS} topics can be driven at once; close a page that drives another"
                    )
                graph = await self._joined()
                publisher = await graph.advertise(topic, message_type)
                commands = DriveCommands(message_type.name, await _read_limits(graph))
                found = self._topics[topic] = CommandTopic(publisher, codec, commands)
            elif found.type.md5sum != message_type.md5sum:
                raise TypeMismatchError(
                    f"{topic[:80]} is driven as {found.type.name}, not as {message_type.name}; use its type"
                )
            else:
                assert self._graph is not None
                found.commands.limits = await _read_limits(self._graph)
            found.users.add(driver)
            return found

    async def leave(self, driver: Driver, topic: str) -> None:
        """Remove a driver from a topic; the topic ends with its last driver."""
        async with self._lock:
            found = self._topics.get(topic)
            if found is None:
                return
            found.leave(driver)
            if not found.users:
                del self._topics[topic]
                await found.close()

    async def close(self) -> None:
        """Stop everything, and leave the graph."""
        async with self._lock:
            for topic in self._topics.values():
                with suppress(RostetherError):
                    await topic.close()
            self._topics.clear()
            if self._graph is not None:
                graph, self._graph = self._graph, None
                await graph.close()
            if self._watching is not None:
                await asyncio.wait([self._watching])

    async def _joined(self) -> Graph:
        if self._graph is None:
            graph = await self._join()
            # The limits are parameters, so that all programs can read and change them.
            with suppress(RostetherError):
                for each in DriveLimits.__struct_fields__:
                    if not await graph.has_param(f"~{each}"):
                        await graph.set_param(f"~{each}", getattr(DriveLimits(), each))
            self._graph = graph
            self._watching = asyncio.ensure_future(self._forget_when_gone(graph))
        return self._graph

    async def _forget_when_gone(self, graph: Graph) -> None:
        reason = await graph.wait_closed()
        if self._graph is graph:
            # The next driver starts a new node.
            self._graph = None
            topics, self._topics = self._topics, {}
            for topic in topics.values():
                topic.end(reason)


async def _read_limits(graph: Graph) -> DriveLimits:
    values: dict[str, object] = {}
    for each in DriveLimits.__struct_fields__:
        with suppress(RostetherError):
            values[each] = await graph.get_param(f"~{each}")
    return DriveLimits.of(values)

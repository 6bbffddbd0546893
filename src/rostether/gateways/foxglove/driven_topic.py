"""A command topic that a client drives under the lease of `teleop/`. Its channel names a driver."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress

from rostether.errors import RostetherError
from rostether.gateways.foxglove import server_messages as replies
from rostether.gateways.foxglove.client_messages import ClientChannel
from rostether.gateways.foxglove.client_sender import ClientSender
from rostether.gateways.foxglove.client_topics import report_once, types_of
from rostether.gateways.foxglove.encoding import Encoder
from rostether.gateways.foxglove.foxglove_context import FoxgloveContext
from rostether.gateways.teleop.teleop import CommandTopic, Teleop
from rostether.mechanisms.text import fold_line

# A display name that fits in a line of the page.
_MAX_NAME_CHARACTERS = 60

# A command is a Twist or a few values. Longer messages may need a long check; a command must not wait.
_MAX_COMMAND_BYTES = 1 << 10


class DrivenTopic:
    """One channel of one client that names a driver, and the driver of its topic.

    `sender` sends the state of the lease to the client, and `warn` reports an error.
    """

    def __init__(
        self,
        channel: ClientChannel,
        context: FoxgloveContext,
        teleop: Teleop,
        sender: ClientSender,
        warn: Callable[[str], None],
    ) -> None:
        driver = fold_line((channel.driver or "")[:_MAX_NAME_CHARACTERS]) or "a page"
        self.channel = channel
        self.name = f"{driver} ({sender.connection.peer})"
        self._context = context
        self._teleop = teleop
        self._sender = sender
        self._warn = warn
        self._warn_once = report_once(warn)
        self._topic = ""
        self._commands: CommandTopic | None = None
        self._encode: Callable[[bytes], bytes] | None = None
        self._reported: tuple[str, str] | None = None
        # The last command that arrived before the topic was open.
        self._early: bytes | None = None
        self._has_ended = False
        self._opening = asyncio.ensure_future(self._open())

    def publish(self, payload: bytes) -> Awaitable[object] | None:
        """Publish a command, unless another client drives; the client need not wait for anything.

        Of the commands that arrive before the topic is open, only the last one counts, if it is a stop.
        """
        if len(payload) > _MAX_COMMAND_BYTES:
            self._warn_once(
                f"a command on {self.channel.topic[:200]} may have at most {_MAX_COMMAND_BYTES} bytes, not "
                f"{len(payload)}"
            )
            return None
        if self._commands is None or self._encode is None:
            self._early = payload
            if self._has_ended:
                self._has_ended = False
                self._opening = asyncio.ensure_future(self._open())
            return None
        try:
            may_drive = self._commands.command(self, self._encode(payload))
        except RostetherError as error:
            self._warn_once(f"a command on {self.channel.topic[:200]} is not published: {error}")
            return None
        if not may_drive:
            self.lease_changed(self._commands.holder)
        return None

    def lease_changed(self, holder: str) -> None:
        """Report which client drives now."""
        state = "free" if not holder else "driving" if holder == self.name else "taken"
        if self._reported != (state, holder):
            self._reported = (state, holder)
            self._sender.send(replies.drive(self.channel.id, state, holder))

    def ended(self, reason: str) -> None:
        """Report that the topic can no longer be driven."""
        self._commands = None
        self._has_ended = True
        self._warn(
            f"{self.channel.topic[:200]} is not driven: the node was shut down ({reason}); "
            "the next command starts it again"
        )

    async def close(self) -> None:
        """Leave the topic; the robot stops if this client was moving it."""
        commands, self._commands = self._commands, None
        if commands is not None:
            commands.leave(self)
        await asyncio.wait([self._opening])
        if self._topic:
            await self._teleop.leave(self, self._topic)

    async def _open(self) -> None:
        try:
            codec, message_type = await types_of(self.channel, self._context.store)
            encode = Encoder.of(self.channel.encoding, codec).encode
            topic = self._context.graph.resolve(self.channel.topic)
            commands = await self._teleop.enter(self, topic, message_type, codec)
        except RostetherError as error:
            self._warn_once(f"{self.channel.topic[:200]} cannot be driven: {error}")
            self._has_ended = self._topic != ""
            return
        self._topic, self._commands, self._encode = topic, commands, encode
        self.lease_changed(commands.holder)
        early, self._early = self._early, None
        # A stop still counts after a long opening. An old command must not start the robot.
        with suppress(RostetherError):
            if early is not None and commands.is_stop(encode(early)):
                self.publish(early)

"""Compares the output of rostether's commands with that of Debian's, on the same graph."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable
from dataclasses import dataclass

from interop.ros1_peers import Ros1Peers

OURS = {"rosparam": "param", "rosmsg": "msg", "rossrv": "srv", "rosnode": "node", "rosservice": "service"}


@dataclass(frozen=True)
class Output:
    """The output and the exit code of a program."""

    code: int
    out: str
    err: str


class SideBySide:
    """Runs the commands of both in the same environment."""

    def __init__(self, peers: Ros1Peers) -> None:
        self._environment = peers.environment
        # More commands at once would only reach their time limits.
        self._slots = asyncio.Semaphore(4)

    async def theirs(self, tool: str, *arguments: str, stdin: str = "") -> Output:
        """Run Debian's tool."""
        return await self._run(tool, *arguments, stdin=stdin)

    async def ours(self, tool: str, *arguments: str, stdin: str = "") -> Output:
        """Run rostether's command for the tool."""
        return await self._run(sys.executable, "-m", "rostether", OURS[tool], *arguments, stdin=stdin)

    async def same(
        self, tool: str, *arguments: str, stdin: str = "", blur: Callable[[str], str] = str
    ) -> str:
        """Run both, assert that output and exit code are the same, and return the output.

        `blur` replaces what differs from run to run, such as times.
        """
        theirs, ours = await asyncio.gather(
            self.theirs(tool, *arguments, stdin=stdin), self.ours(tool, *arguments, stdin=stdin)
        )
        assert (ours.code, blur(ours.out)) == (theirs.code, blur(theirs.out)), (arguments, ours, theirs)
        return ours.out

    async def all_same(self, tool: str, *commands: tuple[str, ...]) -> list[str]:
        """Assert the same for several commands at once, because Debian's tools mostly wait."""
        return await asyncio.gather(*(self.same(tool, *command) for command in commands))

    async def both_fail(self, tool: str, *arguments: str) -> str:
        """Run both, assert that both fail, and return rostether's one line."""
        theirs, ours = await asyncio.gather(self.theirs(tool, *arguments), self.ours(tool, *arguments))
        assert theirs.code != 0, (arguments, theirs)
        assert ours.code != 0, (arguments, ours)
        return ours.err.splitlines()[-1]

    async def _run(self, *command: str, stdin: str) -> Output:
        async with self._slots:
            return await self._run_now(*command, stdin=stdin)

    async def _run_now(self, *command: str, stdin: str) -> Output:
        process = await asyncio.create_subprocess_exec(
            *command,
            env=self._environment,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
        )
        try:
            out, err = await asyncio.wait_for(process.communicate(stdin.encode()), 60)
        except BaseException:
            process.kill()
            await process.wait()
            raise
        assert process.returncode is not None
        return Output(process.returncode, out.decode(), err.decode())

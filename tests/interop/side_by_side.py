"""Compares the output of rostether's commands with that of Debian's, on the same graph."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable
from dataclasses import dataclass

from interop.ros1_peers import Ros1Peers

VERBS = {"rosparam": "param", "rosmsg": "msg", "rossrv": "srv", "rosnode": "node", "rosservice": "service"}


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

    async def run_debian(self, tool: str, *arguments: str, stdin: str = "") -> Output:
        """Run Debian's tool."""
        return await self._run(tool, *arguments, stdin=stdin)

    async def run_rostether(self, tool: str, *arguments: str, stdin: str = "") -> Output:
        """Run rostether's command for the tool."""
        return await self._run(sys.executable, "-m", "rostether", VERBS[tool], *arguments, stdin=stdin)

    async def assert_same(
        self, tool: str, *arguments: str, stdin: str = "", normalize: Callable[[str], str] = str
    ) -> str:
        """Run both, assert that output and exit code are the same, and return the output.

        `normalize` replaces what differs from run to run, such as times.
        """
        debian, rostether = await asyncio.gather(
            self.run_debian(tool, *arguments, stdin=stdin), self.run_rostether(tool, *arguments, stdin=stdin)
        )
        assert (rostether.code, normalize(rostether.out)) == (debian.code, normalize(debian.out)), (
            arguments,
            rostether,
            debian,
        )
        return rostether.out

    async def assert_all_same(self, tool: str, *commands: tuple[str, ...]) -> list[str]:
        """Assert the same for several commands at once, because Debian's tools mostly wait."""
        return await asyncio.gather(*(self.assert_same(tool, *command) for command in commands))

    async def assert_both_fail(self, tool: str, *arguments: str) -> str:
        """Run both, assert that both fail, and return rostether's one line."""
        debian, rostether = await asyncio.gather(
            self.run_debian(tool, *arguments), self.run_rostether(tool, *arguments)
        )
        assert debian.code != 0, (arguments, debian)
        assert rostether.code != 0, (arguments, rostether)
        return rostether.err.splitlines()[-1]

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

"""`rostether up`: runs the parts of a robot on one machine."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

import click

from rostether.cli.shell.failures import usage_text
from rostether.cli.shell.option_group import EXISTING_FILE, add_flag
from rostether.cli.shell.output import write_line
from rostether.cli.shell.own_command import own_command
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.cli.verb_table import VERBS
from rostether.errors import ConfigError
from rostether.mechanisms.tasks import run_until
from rostether.mechanisms.toml_text import read_toml_text
from rostether.platform.boot.interface import interface_address
from rostether.platform.boot.robot_file import INTERFACE_VARIABLE, Part, RobotFile, parse_robot_file
from rostether.ros1.environment import RosEnvironment

# Commands that would start `up` again, or change what starts at boot.
_NOT_PARTS = ("up", "install", "uninstall")
# If the part `core` does not answer within this time, the other parts start without it.
MASTER_LIMIT_S = 30.0
# Parts start or restart soon after the interface gets an address.
ADDRESS_PERIOD_S = 0.5


@verb(
    "up",
    """
    rostether up robot.toml
    rostether up robot.toml --check
    """,
)
@click.argument("file", type=EXISTING_FILE)
@add_flag("--check", "Only check the file, and the arguments of each part.")
def up(file: Path, check: bool) -> None:
    """Run the parts of a robot that FILE lists, and restart each part that ends.

    Each part is a rostether command. A part that hangs for 20 s is ended and started again. A part with
    wrong arguments does not start again; the others run, and the exit code is 1 at the end. `rostether
    install` starts this command at boot.
    """
    robot = read_robot(file)
    if check:
        check_robot(robot, str(file))
        write_line(f"{file}: {', '.join(part.name for part in robot.parts)}")
        return
    if not hasattr(os, "killpg"):
        raise ConfigError("rostether up needs Linux or macOS; start each part in its own terminal")
    environ = {**os.environ, **robot.environment}
    interface = environ.get(INTERFACE_VARIABLE, "")
    if interface and not environ.get("ROS_IP") and sys.platform != "linux":
        raise ConfigError(f'{file}: only Linux finds the address of an interface; give address = "ADDRESS"')

    parts = _Parts(file, robot.parts, environ)

    async def main() -> None:
        if not interface or environ.get("ROS_IP"):
            await parts.run()
        while True:
            environ["ROS_IP"] = await _wait_for_address(interface)
            # Nodes have registered the old address: they cannot be reached at a new one.
            await run_until(parts.run(), _wait_for_address(interface, other_than=environ["ROS_IP"]))
            write_line(f"the network interface {interface} has a new address; all parts start again")

    try:
        run(main(), is_service=True)
    except click.exceptions.Exit:
        if parts.wrong:
            raise ConfigError(
                f"{file}: did not run: {', '.join(sorted(parts.wrong))}; "
                f"`rostether up {file} --check` shows why"
            ) from None
        raise


class _Parts:
    """Runs all parts of a file; `wrong` has the names of the parts with wrong arguments.

    `environ` is the parts' environment; a change applies to parts that start later.
    """

    def __init__(self, file: Path, parts: Sequence[Part], environ: Mapping[str, str]) -> None:
        self._file = file
        self._parts = parts
        self._environ = environ
        self._name_width = max(len(part.name) for part in parts)
        self.wrong: set[str] = set()

    async def run(self) -> NoReturn:
        """Run the parts until canceled. Raises ConfigError if no part can run."""
        self.wrong.clear()
        async with asyncio.TaskGroup() as group:
            for part in sorted(self._parts, key=_is_core, reverse=True):
                running = group.create_task(self._keep_running(part))
                if _is_core(part):
                    # Do not wait for a core that cannot start.
                    await run_until(_wait_for_master(self._environ), asyncio.shield(running))
        hint = f"to see what is wrong: rostether up {self._file} --check"
        raise ConfigError(f"{self._file}: no part can run; {hint}")

    async def _keep_running(self, part: Part) -> None:
        from rostether.platform.boot.part_process import PartProcess

        await PartProcess(part, own_command(), self._environ, self._report).run()
        self.wrong.add(part.name)

    def _report(self, name: str, line: str) -> None:
        write_line(f"{name.ljust(self._name_width)} | {line}")


async def _wait_for_address(interface: str, *, other_than: str = "") -> str:
    """Return the address of an interface, as soon as it has one: at boot, Wi-Fi connects later."""
    is_reported = bool(other_than)
    while (address := interface_address(interface)) in (None, other_than):
        if not is_reported:
            is_reported = True
            write_line(f"waiting until the network interface {interface} has an address")
        await asyncio.sleep(ADDRESS_PERIOD_S)
    assert address is not None
    return address


def _is_core(part: Part) -> bool:
    return part.words[0] == "core"


async def _wait_for_master(environ: Mapping[str, str]) -> None:
    """Wait until the robot's master answers: earlier, other parts would start another master."""
    from rostether.cli.access.served_graphs import wait_for_answer

    with suppress(TimeoutError):
        async with asyncio.timeout(MASTER_LIMIT_S):
            await wait_for_answer(RosEnvironment.read(environ))


def read_robot(path: Path) -> RobotFile:
    """Return the content of a robot.toml, without checking the arguments of its parts. Raises ConfigError."""
    return parse_robot(read_toml_text(path), str(path))


def parse_robot(text: str, file: str) -> RobotFile:
    """Return what the text of a robot.toml contains; `file` is the name in errors. Raises ConfigError."""
    return parse_robot_file(text, file, VERBS.keys() - set(_NOT_PARTS))


def check_robot(robot: RobotFile, file: str) -> None:
    """Raise ConfigError for an address, or for arguments of a part, that cannot be used."""
    try:
        RosEnvironment.read(robot.environment)
    except ConfigError as error:
        raise ConfigError(f"{file}: {error}") from None
    for part in robot.parts:
        try:
            _check_command(part.words)
        except (ConfigError, click.UsageError) as error:
            reason = usage_text(error) if isinstance(error, click.UsageError) else error
            raise ConfigError(f"{file}:parts.{part.name}: {reason}") from None


def _check_command(words: Sequence[str]) -> None:
    """Parse a command line. Raises ConfigError, click.UsageError."""
    from rostether.cli.main import rostether, split_special

    rest, specials = split_special(words)
    command: click.Command | None = rostether
    context = click.Context(rostether, info_name="rostether", obj=specials)
    name: str | None = None
    try:
        while isinstance(command, click.Group):
            if not rest:
                raise ConfigError(f"give a command after {name}")
            name, command, rest = command.resolve_command(context, rest)
            if command is not None and isinstance(command, click.Group):
                context = click.Context(command, info_name=name, parent=context)
        if command is not None:
            with command.make_context(name, rest, parent=context):
                pass
    except click.exceptions.Exit:
        raise ConfigError("--help and --version start nothing; omit them") from None
    except click.BadParameter as error:
        # A file may exist only on the machine that runs the part, or in the folder of its service.
        if error.param is None or not isinstance(error.param.type, click.Path | click.File):
            raise

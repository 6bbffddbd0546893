"""`rostether install`, `uninstall` and `status`: a robot's parts at boot."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import click

from rostether.cli.platform.systemd import UNIT, clean, is_lingering, linger, systemctl
from rostether.cli.platform.up import check_robot, parse_robot, read_robot
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import (
    EXISTING_FILE,
    Function,
    add_flag,
    add_option,
    option,
    option_group,
)
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.own_command import own_command
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import write_failure
from rostether.mechanisms.toml_text import read_toml_text
from rostether.platform.boot.interface import interface_addresses
from rostether.platform.boot.robot_file import Machine, MachineKind
from rostether.platform.boot.service_files import (
    GROUPS,
    Installation,
    default_robot_file,
    files_of,
    path_below,
)

_KINDS = ("base", "robot", "both")
# The address of `rostether dashboard` without options.
_DASHBOARD = "http://127.0.0.1:8765"


@dataclass(frozen=True, slots=True)
class Answers:
    """The description of this machine; the command asks the user for missing parts."""

    machine: str | None = option(
        "--machine", "Set up a base station, a robot, or both.", type=click.Choice(_KINDS)
    )
    name: str | None = option("--name NAME", "The name of this machine: PLATFORM_NAME.")
    core: str | None = option("--core HOST", "The base station, for --machine robot.")
    address: str | None = option("--address ADDRESS", "The address of this machine: ROS_IP.")
    interface: str | None = option(
        "--interface NAME", "The network interface of the fleet; its address is read at boot."
    )
    boards: tuple[str, ...] = option(
        "--board LINK", "A board's link address; may be repeated.", multiple=True
    )
    parts: tuple[str, ...] = option("--part NAME=COMMAND", "Another part; may be repeated.", multiple=True)
    given: Path | None = option("--from", "Use this robot.toml and ask nothing.", type=EXISTING_FILE)


def _target_options(function: Function) -> Function:
    root = add_option(
        "--root",
        "Use the files below this folder, such as a mounted image; start and stop nothing.",
        type=click.Path(file_okay=False, path_type=Path),
    )
    user = add_option(
        "--user/--system for_user",
        "For this user, or for all users (default: --system if root runs it, else --user).",
        default=None,
    )
    return user(root(function))  # type: ignore[no-any-return]


@verb(
    "install",
    """
    rostether install                                        asks what this machine is
    rostether install --machine both --name robot1           a robot with its own core
    rostether install --machine robot --name robot1 --core 192.168.1.10 --interface wlan0
    rostether install --from robot.toml --dry-run            show what would be written
    """,
)
@option_group("answers", Answers)
@add_flag("--gui", "Open the dashboard when a user logs in.")
@add_flag("--dry-run", "Show what would be written.")
@_target_options
def install(answers: Answers, gui: bool, dry_run: bool, for_user: bool | None, root: Path | None) -> None:
    """Start a robot's parts at boot: write a robot.toml and a systemd unit.

    Installing again keeps the robot.toml, unless you give its content again.
    """
    installation = _installation(for_user)
    text = _robot_text(installation.robot_file, root, answers)
    files = {installation.robot_file: text, **files_of(installation, dashboard=_DASHBOARD if gui else "")}
    if dry_run:
        for path, content in files.items():
            write_line(f"{path_below(root, path)}:")
            write_line("\n".join(f"    {line}" for line in content.splitlines()))
        return
    _write(files, root)
    if root is None:
        systemctl(installation, "daemon-reload")
        systemctl(installation, "enable", UNIT)
        # An earlier installation runs with its old files.
        systemctl(installation, "restart", UNIT)
        if not installation.is_system:
            linger()
    else:
        _enable_below(root, installation)
    write_line("rostether starts at boot; to see its state: rostether status")


def _enabling_link(root: Path, installation: Installation) -> Path:
    return path_below(root, installation.enabling_link.parent) / installation.enabling_link.name


def _enable_below(root: Path, installation: Installation) -> None:
    """Make systemd start the unit in an image: `systemctl` only enables units of the running machine."""
    link = _enabling_link(root, installation)
    with _changing(link):
        link.parent.mkdir(exist_ok=True)
        link.unlink(missing_ok=True)
        link.symlink_to(installation.unit)
    write_line(f"wrote {link}")


@verb("uninstall", "rostether uninstall")
@_target_options
def uninstall(for_user: bool | None, root: Path | None) -> None:
    """Stop the robot's parts, and remove the files of `rostether install`, including robot.toml."""
    installation = _installation(for_user)
    written = [installation.robot_file, installation.unit, installation.autostart]
    written += [installation.rules] if installation.is_system else []
    paths = [each for each in written if path_below(root, each).exists()]
    if not paths:
        write_line("nothing is installed")
        return
    if root is None:
        systemctl(installation, "disable", "--now", UNIT)
        if installation.is_system:
            clean(installation)
        elif is_lingering():
            write_line("your services may still start at boot; to prevent this: loginctl disable-linger")
    else:
        link = _enabling_link(root, installation)
        with _changing(link):
            link.unlink(missing_ok=True)
    for path in paths:
        target = path_below(root, path)
        with _changing(target):
            target.unlink()
        write_line(f"removed {target}")
    folder = path_below(root, installation.robot_file).parent
    if folder.name == "rostether" and not any(folder.iterdir()):
        folder.rmdir()
    if root is None:
        systemctl(installation, "daemon-reload")


@verb("status", "rostether status")
@_target_options
def status(for_user: bool | None, root: Path | None) -> int:
    """Show what starts at boot, and whether it runs. The exit code is 1 if nothing is installed."""
    installation = _installation(for_user)
    file = path_below(root, installation.robot_file)
    if not path_below(root, installation.unit).exists():
        write_line("nothing starts at boot; to change that: rostether install")
        return EXIT_FAILED
    robot = read_robot(file)
    write_line(f"{robot.name or 'this machine'}: {', '.join(part.name for part in robot.parts)}  ({file})")
    try:
        check_robot(robot, str(file))
    except ConfigError as error:
        # systemd shows the service as running: the other parts run.
        warn(f"{error}; a part with wrong arguments does not run")
    if root is None:
        shown = systemctl(installation, "show", UNIT, "-p", "ActiveState,SubState")
        states = dict(line.split("=", 1) for line in shown.splitlines() if "=" in line)
        write_line(f"{states.get('ActiveState', 'unknown')} ({states.get('SubState', 'unknown')})")
        write_line(f"log: journalctl {'' if installation.is_system else '--user '}-u rostether")
    return EXIT_DONE


def _installation(for_user: bool | None) -> Installation:
    if not hasattr(os, "geteuid"):
        raise ConfigError("this system has no systemd; only Linux can start rostether at boot")
    is_system = os.geteuid() == 0 if for_user is None else not for_user
    program = shutil.which("rostether")
    return Installation(
        program=(program,) if program is not None else tuple(own_command()),
        robot_file=default_robot_file(is_system),
        is_system=is_system,
        user=os.environ.get("SUDO_USER", "") if is_system else "",
        groups=tuple(each for each in GROUPS if _has_group(each)) if is_system else (),
    )


def _has_group(name: str) -> bool:
    # Windows has no such module.
    import grp

    try:
        grp.getgrnam(name)
    except KeyError:
        return False
    return True


def _robot_text(file: Path, root: Path | None, answers: Answers) -> str:
    if (given := answers.given) is not None:
        text = read_toml_text(given)
        check_robot(parse_robot(text, str(given)), str(given))
        return text
    kept = path_below(root, file)
    if answers == Answers() and kept.exists():
        text = read_toml_text(kept)
        parse_robot(text, str(kept))
        return text
    kind = MachineKind(answers.machine or _ask("What is this machine", "both", _KINDS))
    name = answers.name or _ask("Name of this machine", os.uname().nodename)
    core, interface = answers.core or "", answers.interface or ""
    if kind is MachineKind.ROBOT and not core:
        core = _ask("Address of the base station")
    if not answers.machine and not answers.address and not interface:
        interface = _ask_interface()
    parts = {}
    for each in answers.parts:
        key, separator, words = each.partition("=")
        if not separator or not key:
            raise ConfigError(f"--part {each!r} must be NAME=COMMAND, such as joystick='role joy-node'")
        parts[key] = words
    text = Machine(kind, name, core, answers.address or "", interface, answers.boards, parts).text
    check_robot(parse_robot(text, "the new robot.toml"), "the new robot.toml")
    return text


def _ask_interface() -> str:
    found = interface_addresses()
    listed = ", ".join(f"{name} ({address})" for name, address in found.items()) or "none has an address now"
    answer = _ask(f"Network interface of the fleet: {listed}; any: chosen by the system", "any")
    return "" if answer == "any" else answer


def _ask(question: str, default: str | None = None, choices: Sequence[str] | None = None) -> str:
    if not sys.stdin.isatty():
        raise ConfigError(
            f"{question}? There is no terminal to ask; give --machine, --name and, for a robot, --core"
        )
    kind = click.Choice(choices) if choices is not None else None
    answer: str = click.prompt(question, default=default, type=kind)
    return answer


def _write(files: Mapping[Path, str], root: Path | None) -> None:
    for path, content in files.items():
        target = path_below(root, path)
        with _changing(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(content, encoding="utf-8")
        write_line(f"wrote {target}")


@contextmanager
def _changing(path: Path) -> Iterator[None]:
    """Raise ConfigError with the next step if the block cannot change a file."""
    try:
        yield
    except PermissionError as error:
        raise ConfigError(
            f"cannot change {path}: {error.strerror}; run the command with sudo, or add --user"
        ) from None
    except OSError as error:
        raise ConfigError(write_failure(path, error)) from None

"""`rostether env`: prints the shell code for ROS 1 commands."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import click

from rostether.cli.launch.shims import real_ros_commands, write_shims
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.verbs import Verb

SHELLS = ("sh", "bash", "zsh", "fish")

_ROSCD = """\
command -v roscd >/dev/null 2>&1 || roscd() {
    _rostether_folder=$(rospack find "${1%%/*}") || return
    case "$1" in */*) _rostether_folder=$_rostether_folder/${1#*/} ;; esac
    cd "$_rostether_folder"
}"""
_ROSCD_FISH = """\
type -q roscd; or function roscd
    set -l parts (string split -m 1 / -- $argv[1])
    set -l folder (rospack find $parts[1]); or return
    cd (string join / -- $folder $parts[2])
end"""


@click.command(
    "env",
    cls=Verb,
    examples="""
    eval "$(rostether env)"                          in this shell
    echo 'eval "$(rostether env)"' >> ~/.bashrc      permanently
    rostether env --shell fish | source
    eval "$(rostether env --first)"                  even where a real ROS is installed
    """,
)
@click.option("--shell", type=click.Choice(SHELLS), help="The shell (default: $SHELL).")
@click.option("--first", is_flag=True, help="Put rostether's commands before those of a real ROS on PATH.")
def env(shell: str | None, first: bool) -> None:
    """Print shell code that adds roscore, rosrun, roslaunch, rostopic and others to PATH.

    If a real ROS is installed, its commands keep precedence, unless you give --first.
    """
    folder = write_shims()
    path = os.environ.get("PATH", "")
    others = real_ros_commands(path, folder)
    if others and not first:
        some = ", ".join(str(each) for each in list(others.values())[:3])
        more = f" and {len(others) - 3} more" if len(others) > 3 else ""
        warn(
            f"a real ROS is installed, and its commands keep precedence ({some}{more}); --first changes that"
        )
    name = shell or Path(os.environ.get("SHELL", "sh")).name
    write_line(shell_code(folder, first=first, is_fish=name == "fish"))


def shell_code(folder: Path, *, first: bool, is_fish: bool) -> str:
    """Return the code: it adds the folder to PATH once, and defines `roscd`, which must be a function."""
    quoted = shlex.quote(str(folder))
    if is_fish:
        where = f"set -gx PATH {quoted} $PATH" if first else f"set -gx PATH $PATH {quoted}"
        return f"contains -- {quoted} $PATH; or {where}\n{_ROSCD_FISH}"
    where = f'PATH={quoted}"${{PATH:+:$PATH}}"' if first else f'PATH="${{PATH:+$PATH:}}"{quoted}'
    if first:
        return f"{where}\nexport PATH\n{_ROSCD}"
    return f'case ":$PATH:" in *:{quoted}:*) ;; *) {where} ;; esac\nexport PATH\n{_ROSCD}'

"""The `rostether` command: its entry point, its ROS arguments, and its output streams."""

from __future__ import annotations

import itertools
import os
import re
import sys
import warnings
from collections.abc import Sequence

import click

from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED, error_text, exit_code_of, print_error
from rostether.cli.shell.verbs import LazyGroup
from rostether.cli.verb_table import VERBS, suggest

_SPECIAL = re.compile(r"(__(?:name|ns|log|master|ip|hostname)):=(.*)", re.DOTALL)

# Begins the arguments of a node in the form of ROS 2; for `launch`, it is an option, as in roslaunch.
_ROS_ARGS = "--ros-args"

# The commands that read their ROS arguments themselves.
_WITH_OWN_ROS_ARGUMENTS = ("serial-node", "run")


@click.group(
    cls=LazyGroup,
    verbs=VERBS,
    suggest=suggest,
    examples="""
    rostether demo                         a simulated board, live
    rostether serve /dev/ttyACM0           your board, master included
    rostether topic list                   what it publishes
    rostether topic echo /ultrasound       its values
    """,
)
@click.version_option(None, "-V", "--version", package_name="rostether", prog_name="rostether")
def rostether() -> None:
    """Connect microcontrollers with rosserial firmware to ROS, without a ROS installation."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code; never raises for a user error."""
    _prepare_output()
    if not sys.warnoptions:
        # Python warns about some valid expressions of users, such as "1if m else 0".
        warnings.simplefilter("ignore", SyntaxWarning)
    plain, specials = split_special(sys.argv[1:] if arguments is None else arguments)
    code = exit_code_of(
        lambda: rostether.main(plain, prog_name="rostether", standalone_mode=False, obj=specials)
    )
    return _flush_output(code)


def split_special(arguments: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Return a command line without its ROS arguments such as `__name:=x`, and those arguments.

    roslaunch adds them to every command it starts. Arguments after `run` belong to the node.
    """
    if arguments and arguments[0] in _WITH_OWN_ROS_ARGUMENTS:
        return list(arguments), {}
    if _ROS_ARGS in arguments and arguments[0] != "launch":
        arguments = _in_ros1_form(arguments)
    specials = {match[1]: match[2] for each in arguments if (match := _SPECIAL.fullmatch(each))}
    return [each for each in arguments if not _SPECIAL.fullmatch(each)], specials


def _in_ros1_form(arguments: Sequence[str]) -> list[str]:
    """Return a command line whose arguments from `--ros-args` to `--` have the form of ROS 1.

    `-r a:=b` is `a:=b`, and `-p a:=1` is `_a:=1`. Others, such as --log-level, have no meaning here.
    """
    begin = arguments.index(_ROS_ARGS)
    rest = list(arguments[begin + 1 :])
    end = rest.index("--") if "--" in rest else len(rest)
    words, following = rest[:end], rest[end + 1 :]
    found = []
    for option, value in itertools.pairwise([*words, ""]):
        if option in ("-r", "--remap"):
            found.append(value.replace("__node:=", "__name:="))
        elif option in ("-p", "--param"):
            found.append(f"_{value}")
        elif option == "--params-file":
            found += [option, value]
    return [*arguments[:begin], *found, *following]


def _flush_output(code: int) -> int:
    """Write buffered output; return the exit code, which is EXIT_FAILED if output is lost.

    If the output cannot be written at Python's exit, Python prints a traceback.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError as error:
            from rostether.cli.shell.output import discard_output

            discard_output(stream)
            # A closed pipe (`| head`) is not a failure; a full disk is one, because output is lost.
            if code == EXIT_DONE and not isinstance(error, BrokenPipeError):
                print_error(error_text(error))
                code = EXIT_FAILED
    return code


def _prepare_output() -> None:
    # A stream that the caller has closed (`>&-`) is None.
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: PTH123, SIM115 - for the rest of the process
    # Strings from boards may contain bytes that are not UTF-8, as surrogates: print these bytes unchanged.
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            is_utf8 = (stream.encoding or "").lower().replace("-", "") == "utf8"
            if is_utf8:
                reconfigure(errors="surrogateescape")
                continue
            from rostether.cli.shell import ascii_pictures

            ascii_pictures.register()
            reconfigure(errors=ascii_pictures.ERROR_HANDLER)

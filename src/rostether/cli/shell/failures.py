"""How a command ends: one line for each failure, exit codes 0 done, 1 failed, 2 usage, 130 interrupted.

A traceback shown to a user is a defect; ROSTETHER_TRACEBACK=1 asks for one.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable

import click

from rostether.cli.shell.interrupts import TerminatedError
from rostether.errors import RostetherError, first_error
from rostether.mechanisms.text import fold_line

EXIT_DONE = 0
EXIT_FAILED = 1
EXIT_INTERRUPTED = 130
# How click suggests similar options.
_SIMILAR = re.compile(r"(?P<problem>.*)\. \(?Did you mean(?: one of:)? (?P<names>.*?)\?\)?")
# Plain words for click's messages about values of the wrong type.
_PLAIN_MESSAGES = {
    "is not a valid float range": "is not a number",
    "is not a valid integer range": "is not a whole number",
    "is not a valid float": "is not a number",
    "is not a valid integer": "is not a whole number",
}
TRACEBACK_VARIABLE = "ROSTETHER_TRACEBACK"


def exit_code_of(command: Callable[[], object]) -> int:
    """Run a command, print the reason if it fails, and return its exit code; never raises."""
    try:
        code = command()
    except (KeyboardInterrupt, click.Abort):
        return EXIT_INTERRUPTED
    except (click.exceptions.Exit, TerminatedError) as ending:
        return ending.exit_code
    except SystemExit:
        # click raises this when the reader of its help closes the pipe (`--help | head`).
        return EXIT_DONE
    except click.ClickException as error:
        return _report_usage(error)
    except Exception as error:  # noqa: BLE001 - a user never sees a traceback
        return EXIT_INTERRUPTED if _is_interruption(error) else _report(error)
    return code if isinstance(code, int) else EXIT_DONE


def _is_interruption(error: BaseException | None) -> bool:
    """Return whether Ctrl-C caused an error; Python 3.11 may wrap it in a RuntimeError."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


def error_text(error: BaseException) -> str:
    """Return the text of an error as one line, without the name of its class if the text is clear."""
    error = first_error(error)
    text = fold_line(str(error))
    if isinstance(error, RostetherError) and text:
        return text
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return (
        f"{type(error).__name__}: {text} (unexpected; please report it with the output of "
        f"{TRACEBACK_VARIABLE}=1)"
    )


def print_error(text: str) -> None:
    """Write one error line to stderr."""
    click.echo(f"rostether: error: {text}", err=True)


def _report_usage(error: click.ClickException) -> int:
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        click.echo(error.format_message(), err=True)
        return error.exit_code
    print_error(usage_text(error))
    return error.exit_code


def usage_text(error: click.ClickException) -> str:
    """Return the text of a usage error as one line, with similar options or the command for help."""
    context = getattr(error, "ctx", None)
    text = fold_line(error.format_message()).rstrip(".")
    if similar := _SIMILAR.fullmatch(text):
        names = similar["names"].replace("'", "").replace(",", " or")
        return f"{similar['problem']}; did you mean {names}?"
    for unclear, plain in _PLAIN_MESSAGES.items():
        text = text.replace(unclear, plain)
    # Rostether's usage errors name the next step; those of click only name the problem.
    if context is not None and (type(error) is not click.UsageError or "unexpected extra" in text):
        return f"{text}; see `{context.command_path} --help`"
    return text


def _report(error: Exception) -> int:
    if os.environ.get(TRACEBACK_VARIABLE):
        import traceback

        traceback.print_exception(error)
    print_error(error_text(error))
    return EXIT_FAILED

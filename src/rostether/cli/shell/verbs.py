"""The classes of rostether's click commands: verbs are imported only when used, and help shows examples."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Coroutine, Iterable, Iterator, Mapping
from importlib import import_module
from itertools import groupby
from textwrap import dedent
from types import MappingProxyType
from typing import Any, NamedTuple

import click
from click.shell_completion import CompletionItem

from rostether.cli.shell.interrupts import raise_at_interrupt
from rostether.cli.shell.option_group import OptionalValueOption, option_sections

# Maximum width of help text: longer lines are hard to read on wide terminals.
HELP_WIDTH = 100

# With click's own minimum, a narrow terminal would break each line a second time.
_MIN_HELP_WIDTH = 20
# Below it, an option's text has too little space beside the option.
_WIDTH_FOR_COLUMNS = 60

_LONG_DASHES = ("\u2013", "\u2014", "\u2212")
# The module of the groups: importing it imports no verb.
_GROUPS = "rostether.cli.groups:"
# click's names of the types of numbers.
_CLICK_TYPES = re.compile(r"(?:INTEGER|FLOAT)(?: RANGE)?")
_COMMENTED = re.compile(r"(\S.*?) {2,}(\S.*)")
# With difflib's own limit, `stop` would be similar to `topic`.
_MIN_SIMILARITY = 0.7


class VerbEntry(NamedTuple):
    """The location of a verb (`module:attribute`), and its line and heading in the help.

    The help is shown without an import of the verb.
    """

    target: str
    summary: str
    heading: str


def verb_entries(
    package: str, verbs: Mapping[str, tuple[str, str]], *, heading: str = "Commands"
) -> dict[str, VerbEntry]:
    """Return a table of verbs from pairs of a location, relative to a package, and a line in the help."""
    return {
        name: VerbEntry(f"{package}.{target}", summary, heading) for name, (target, summary) in verbs.items()
    }


class _Formatter(click.HelpFormatter):
    """Writes help that fits narrow terminals too."""

    def write_dl(self, rows: Iterable[tuple[str, str]], col_max: int = 30, col_spacing: int = 2) -> None:
        """Write options with their texts beside them, or on a narrow terminal below them."""
        rows = [(_CLICK_TYPES.sub("NUMBER", first), text) for first, text in rows]
        super().write_dl(rows, col_max if self.width >= _WIDTH_FOR_COLUMNS else 2, col_spacing)


class _Context(click.Context):
    formatter_class = _Formatter

    def make_formatter(self) -> click.HelpFormatter:
        """Return the formatter for this terminal's width."""
        columns = min(shutil.get_terminal_size().columns, self.max_content_width or HELP_WIDTH)
        return self.formatter_class(width=max(columns - 2, _MIN_HELP_WIDTH))


class _CommandWithExamples(click.Command):
    """A command whose help ends with examples to copy."""

    context_class = _Context

    def __init__(self, *args: Any, examples: str = "", **kwargs: Any) -> None:
        kwargs["context_settings"] = {
            "help_option_names": ["-h", "--help"],
            "max_content_width": HELP_WIDTH,
            **(kwargs.get("context_settings") or {}),
        }
        super().__init__(*args, **kwargs)
        self.examples = dedent(examples).strip("\n")

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples as given, or with each comment below its command if they are too wide."""
        super().format_epilog(ctx, formatter)
        if not self.examples:
            return
        formatter.write("\nExamples:\n")
        lines = self.examples.splitlines()
        if any(len(line) + 2 > formatter.width for line in lines):
            lines = list(_with_comments_below(lines))
        for line in lines:
            formatter.write(f"  {line}\n" if line else "\n")


class Verb(_CommandWithExamples):
    """A command of the command line; its function may be a coroutine function.

    With `is_service`, `shell.running.run` runs the coroutine as a service. `old_options` maps former names of
    options, which stay accepted, to the current ones; `hints` maps options that users expect to the right
    spelling.
    """

    def __init__(
        self,
        *args: Any,
        is_service: bool = False,
        old_options: Mapping[str, str] = MappingProxyType({}),
        hints: Mapping[str, str] = MappingProxyType({}),
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self.is_service = is_service
        self.old_options = old_options
        self.hints = hints

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; `–once`, as books and PDFs print it, is `--once`."""
        known = {option for parameter in self.get_params(ctx) for option in parameter.opts}
        plain = [_plain_dashes(each, {*known, *self.old_options}) for each in args]
        plain = self._renamed(plain)
        for parameter in self.get_params(ctx):
            if isinstance(parameter, OptionalValueOption):
                plain = parameter.insert_value(plain)
        try:
            return super().parse_args(ctx, plain)
        except click.NoSuchOption as error:
            if hint := self.hints.get(error.option_name):
                ctx.fail(f"no option {error.option_name}; {hint}")
            raise

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; from now on Ctrl-C raises KeyboardInterrupt, so that the command can clean up."""
        raise_at_interrupt()
        result = super().invoke(ctx)
        if not isinstance(result, Coroutine):
            return result
        from rostether.cli.shell.running import run

        return run(result, is_service=self.is_service)

    def _renamed(self, arguments: list[str]) -> list[str]:
        end = arguments.index("--") if "--" in arguments else len(arguments)
        renamed = []
        for each in arguments[:end]:
            name, equals, value = each.partition("=")
            renamed.append(self.old_options.get(name, name) + equals + value)
        return renamed + arguments[end:]

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options under their headings."""
        for heading, records in option_sections(self, ctx).items():
            with formatter.section(heading):
                formatter.write_dl(records)


def verb(
    name: str, examples: str, *, cls: type[Verb] = Verb, **settings: Any
) -> Callable[[Callable[..., Any]], Verb]:
    """Return a decorator that makes a function a verb; its docstring is the help.

    `examples` are command lines for the end of the help; `settings` are more arguments of `click.command`.
    """
    return click.command(name, cls=cls, examples=examples, **settings)


class LazyGroup(_CommandWithExamples, click.Group):
    """A group of verbs, each imported when used, so that commands start quickly.

    `suggest` returns the commands for a word that users of other tools type, as words after `rostether`.
    """

    def __init__(
        self,
        *args: Any,
        verbs: Mapping[str, VerbEntry],
        suggest: Callable[[str], Iterable[str]] = lambda _word: (),
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self.verbs = dict(verbs)
        self.suggest = suggest

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the verbs in the order of their table, which suits newcomers."""
        return list(self.verbs)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a verb; None if there is no such verb."""
        entry = self.verbs.get(cmd_name)
        if entry is None:
            return None
        module_name, _, attribute = entry.target.partition(":")
        command: click.Command = getattr(import_module(module_name), attribute)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the given verb, or fail and suggest similar ones."""
        name = args[0]
        if name == "help" and name not in self.verbs:
            if ctx.resilient_parsing:
                # The shell completes the verb after `help`.
                return name, self, args[1:]
            if not args[1:]:
                click.echo(ctx.get_help())
                ctx.exit()
            return self.resolve_command(ctx, [*args[1:], "--help"])
        if name not in self.verbs and not name.startswith("-") and not ctx.resilient_parsing:
            ctx.fail(f"no such command {name!r}; {self._hint(ctx, args)}")
        return super().resolve_command(ctx, args)

    def _hint(self, ctx: click.Context, args: list[str]) -> str:
        from difflib import get_close_matches

        name = args[0]
        # `rostether echo` for `rostether topic echo`.
        whole = [f"`{ctx.command_path} {group} {name}`" for group in self._groups_with(ctx, name)]
        whole += [f"`{ctx.find_root().command_path} {words}`" for words in self.suggest(name)]
        if whole:
            return f"did you mean {' or '.join(whole[:3])}?"
        # For difflib, swapped letters make short words too different.
        swapped = [each for each in self.verbs if sorted(each) == sorted(name)]
        if near := swapped or get_close_matches(name, self.verbs, cutoff=_MIN_SIMILARITY):
            return f"did you mean {' or '.join(near)}?"
        return f"see `{ctx.command_path} --help`"

    def _groups_with(self, ctx: click.Context, name: str) -> Iterator[str]:
        for group_name, entry in self.verbs.items():
            if entry.target.startswith(_GROUPS):
                group = self.get_command(ctx, group_name)
                if isinstance(group, LazyGroup) and name in group.verbs:
                    yield group_name

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the verbs with their one-line summaries, in columns of one width under their headings."""
        width = max(map(len, self.verbs)) if formatter.width >= _WIDTH_FOR_COLUMNS else 0
        for heading, group in groupby(self.verbs.items(), lambda item: item[1].heading):
            with formatter.section(heading):
                formatter.write_dl([(name.ljust(width), entry.summary) for name, entry in group])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete verbs from the table, without importing them, and the group's own options."""
        verbs = [
            CompletionItem(name, help=entry.summary)
            for name, entry in self.verbs.items()
            if name.startswith(incomplete)
        ]
        return verbs + click.Command.shell_complete(self, ctx, incomplete)


def verb_group(
    name: str,
    text: str,
    verbs: Mapping[str, tuple[str, str]],
    examples: str,
    *,
    package: str = "",
    **settings: Any,
) -> LazyGroup:
    """Return a group of verbs; `text` is its help, and `settings` are more arguments of `LazyGroup`.

    The locations of the verbs are relative to `package`, by default rostether.cli.NAME.
    """
    entries = verb_entries(package or f"rostether.cli.{name}", verbs)
    return LazyGroup(name, verbs=entries, help=text, examples=examples, **settings)


def _plain_dashes(argument: str, known: set[str]) -> str:
    if argument[:1] in _LONG_DASHES:
        for dashes in ("--", "-"):
            if dashes + argument[1:] in known:
                return dashes + argument[1:]
    return argument


def _with_comments_below(lines: list[str]) -> Iterator[str]:
    for line in lines:
        match = _COMMENTED.fullmatch(line)
        yield match[1] if match else line
        if match:
            yield f"    {match[2]}"

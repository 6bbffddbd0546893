"""Adds the pages of the commands to the documentation, and removes what only tests need."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import click
from mkdocs.structure.files import File, Files

FOLDER = "reference/commands"
INTRODUCTION = """# Commands

One page for each command. `rostether COMMAND --help` shows the same text in a terminal.

Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted. With `--json` a command prints one object a
line.
`ROS_MASTER_URI`, `ROS_IP`, `ROS_HOSTNAME`, `ROS_NAMESPACE` and `ROS_PACKAGE_PATH` have the same meaning as
in ROS 1; [Environment variables and files](../environment.md) lists all variables.
Every command accepts arguments such as `__name:=x` or `__ns:=/lab`.
"""
_MARK = re.compile(r'^(```.*?) test="[^"]*"', re.MULTILINE)
_MARKDOWN = re.compile(r"[\\*_\[\]<>|#&]")


def on_config(config: Any) -> Any:
    """Add the commands' pages to the navigation."""
    pages = [{name: f"{FOLDER}/{name}.md"} for name, _ in _commands()]
    for section in config["nav"]:
        for entry in section.get("Reference", ()):
            if "Commands" in entry:
                entry["Commands"] = [f"{FOLDER}/index.md", *pages]
    return config


def on_files(files: Files, config: Any) -> Files:
    """Write the commands' pages from their help."""
    from rostether.cli.main import rostether

    texts, index, heading = {}, [INTRODUCTION], ""
    for name, command in _commands():
        if heading != rostether.verbs[name].heading:
            heading = rostether.verbs[name].heading
            index.append(f"\n## {heading}\n\n| command | purpose |\n| --- | --- |\n")
        index.append(f"| [`rostether {name}`]({name}.md) | {_escape(command.get_short_help_str(200))} |\n")
        texts[name] = "\n".join(_page(command, _context(command, f"rostether {name}"), 1))
    texts["index"] = "".join(index)
    for name, text in texts.items():
        files.append(File.generated(config, f"{FOLDER}/{name}.md", content=text))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Remove the marks of the tests."""
    return _MARK.sub(r"\1", markdown)


def _commands() -> list[tuple[str, click.Command]]:
    from rostether.cli.main import rostether

    context = click.Context(rostether, info_name="rostether")
    found = ((name, rostether.get_command(context, name)) for name in rostether.list_commands(context))
    return [(name, command) for name, command in found if command is not None and not command.hidden]


def _context(command: click.Command, path: str) -> click.Context:
    # Also has the names of the option for help, which click keeps in the command.
    return click.Context(command, info_name=path, **command.context_settings)


def _page(command: click.Command, context: click.Context, level: int) -> Iterator[str]:
    from rostether.cli.shell.option_group import option_sections

    yield f"{'#' * level} {context.command_path}\n"
    yield from _paragraphs(command.help or "")
    yield f"```\n{' '.join([context.command_path, *command.collect_usage_pieces(context)])}\n```\n"
    for heading, records in option_sections(command, context).items():
        yield f"{heading}:\n"
        for spelling, text in records:
            yield f"`{spelling}`\n:   {_escape(text)}\n"
    examples = getattr(command, "examples", "")
    if examples:
        yield f"Examples:\n\n```sh\n{examples}\n```\n"
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            child = command.get_command(context, name)
            if child is not None and not child.hidden:
                yield from _page(child, _context(child, f"{context.command_path} {name}"), min(level + 1, 4))


def _paragraphs(text: str) -> Iterator[str]:
    for paragraph in inspect.cleandoc(text).split("\n\n"):
        # Click's mark for text that keeps its lines.
        if paragraph.startswith("\b"):
            yield f"```\n{paragraph[1:].strip(chr(10))}\n```\n"
        else:
            yield f"{_escape(' '.join(paragraph.split()))}\n"


def _escape(text: str) -> str:
    """Return text that Markdown shows unchanged, except for code in backticks."""
    parts = text.split("`")
    return "`".join(part if index % 2 else _MARKDOWN.sub(_entity, part) for index, part in enumerate(parts))


def _entity(match: re.Match[str]) -> str:
    return f"&#{ord(match[0])};"

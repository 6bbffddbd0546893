"""Reads <param> and <rosparam>: values from attributes, files, programs and YAML."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rostether.errors import LaunchError
from rostether.launch.files import BUILTIN_ROOT, MAX_FILE_BYTES, read_file
from rostether.launch.plan import DeleteParameters, DumpParameters
from rostether.launch.substitution import LaunchContext
from rostether.launch.tag import Tag
from rostether.launch.values import convert, split_words
from rostether.names.graph_name import canonical, is_private, join
from rostether.param_yaml import leaves, parse_single_document

_SOURCES = ("value", "textfile", "binfile", "command")
_PARAM_ATTRIBUTES = ("name", "type", *_SOURCES)
_ROSPARAM_ATTRIBUTES = ("command", "ns", "file", "param", "subst_value")
_COMMANDS = ("load", "dump", "delete")
# Launch files run xacro as `$(find xacro)/xacro`, older ones as `$(find xacro)/xacro.py`.
_SCRIPT_SUFFIX = ".py"


def read_param(tag: Tag) -> None:
    """Set the parameter of a <param>, or store a private one for the following nodes.

    Raises LaunchError, ConfigError.
    """
    name, value = name_and_value(tag)
    if is_private(name):
        tag.scope.private_params[name] = value
    else:
        tag.set_parameter(join(tag.scope.namespace, name), value)


def name_and_value(tag: Tag) -> tuple[str, Any]:
    """Return the name, which may begin with `~`, and value of a <param>. Raises LaunchError, ConfigError."""
    tag.check_attributes(_PARAM_ATTRIBUTES)
    given = {source: tag.optional(source) for source in _SOURCES}
    sources = [(source, text) for source, text in given.items() if text is not None]
    if len(sources) != 1:
        raise LaunchError(f"<param> needs one of {', '.join(f'{each}=' for each in _SOURCES)}")
    name = tag.required("name").strip()
    if not name:
        raise LaunchError("<param> has an empty name=; give the parameter a name")
    (source, text), type_name = sources[0], tag.element.attributes.get("type", "").lower().strip() or "auto"
    return name, _value(source, text, type_name, tag.reading.context)


def read_rosparam(tag: Tag) -> None:
    """Load parameters, or add a step to the plan that dumps or deletes parameters before the launch.

    Raises LaunchError, ConfigError.
    """
    tag.check_attributes(_ROSPARAM_ATTRIBUTES)
    command = tag.optional("command") or "load"
    file = tag.optional("file")
    # `ns` is an older name of `param`.
    name = join(tag.optional("ns") or "", tag.optional("param") or "")
    replaces = tag.flag("subst_value")
    if is_private(name):
        tag.warn(f"param={name!r} is not private to the node; write it without ~ inside its <node>")
    full_name = join(tag.scope.namespace, name) if name else tag.scope.namespace
    before = tag.reading.plan.before
    match command:
        case "load":
            _load(tag, name, full_name, file, replaces=replaces)
        case "dump":
            if not file:
                raise LaunchError("<rosparam command='dump'> needs file=, the file to write")
            before.append(DumpParameters(canonical(full_name), file))
        case "delete":
            if file is not None:
                raise LaunchError("<rosparam command='delete'> cannot have file=; remove it")
            before.append(DeleteParameters(canonical(full_name)))
        case _:
            raise LaunchError(f"<rosparam> has no command {command!r}; known: {', '.join(_COMMANDS)}")


def _load(tag: Tag, name: str, full_name: str, file: str | None, *, replaces: bool) -> None:
    text, source = tag.element.text, "its YAML"
    if file is not None:
        text, source = _read_text(file), file
    if replaces:
        text = tag.substitute(text)
    data = parse_single_document(text, source)
    data = {} if data is None else data
    if not name and not isinstance(data, dict):
        raise LaunchError("<rosparam> needs param=, because its value is not a mapping")
    for key, value in leaves(full_name, data):
        tag.set_parameter(key, value)


def _value(source: str, text: str, type_name: str, context: LaunchContext) -> Any:
    match source:
        case "value":
            return convert(text.strip(), type_name)
        case "textfile":
            return convert(_read_text(text), type_name)
        case "binfile":
            return _read_bytes(text)
    return convert(_output_of(text, context), type_name) if context.runs_commands else ""


def _output_of(command: str, context: LaunchContext) -> str:
    words = split_words(command)
    if not words:
        raise LaunchError("<param command=''> is empty; give a command")
    words = [*_program(words[0], context), *words[1:]]
    try:
        with subprocess.Popen(  # noqa: S603 - running it is what command= is for
            words, stdout=subprocess.PIPE, env=dict(context.environ)
        ) as process:
            assert process.stdout is not None
            try:
                output = process.stdout.read(MAX_FILE_BYTES + 1)
                if len(output) > MAX_FILE_BYTES:
                    process.kill()
            except BaseException:
                # Ctrl-C must not leave the command running.
                process.kill()
                raise
    except OSError as error:
        raise LaunchError(
            f"cannot run {words[0]!r}: {error.strerror or error}; install it, or correct command="
        ) from None
    if len(output) > MAX_FILE_BYTES:
        raise LaunchError(
            f"the command {command!r} prints more than {MAX_FILE_BYTES} bytes, too many for a parameter; "
            "shorten its output"
        )
    if process.returncode != 0:
        raise LaunchError(f"the command {command!r} failed with code {process.returncode}; run it to see why")
    try:
        return output.decode()
    except UnicodeDecodeError:
        raise LaunchError(
            f"the output of {command!r} is not UTF-8; give a command that prints text"
        ) from None


def _program(word: str, context: LaunchContext) -> Sequence[str]:
    path = Path(word)
    if path.parent.parent == Path(BUILTIN_ROOT):
        built_in = context.programs.get((path.parent.name, path.name.removesuffix(_SCRIPT_SUFFIX)))
        if built_in is None:
            raise LaunchError(f"package {path.parent.name!r} is not installed; install it")
        return built_in
    search_path = context.environ.get("PATH")
    if (word, word) in context.programs and shutil.which(word, path=search_path) is None:
        return context.programs[word, word]
    return [word]


def _read_bytes(file: str) -> bytes:
    data = read_file(file)
    if len(data) > MAX_FILE_BYTES:
        raise LaunchError(
            f"{file} is larger than {MAX_FILE_BYTES} bytes, too large for a parameter; shorten it"
        )
    return data


def _read_text(file: str) -> str:
    try:
        text = _read_bytes(file).decode()
    except UnicodeDecodeError as error:
        raise LaunchError(
            f"{file} is not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")

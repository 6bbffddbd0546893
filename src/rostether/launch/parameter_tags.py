"""Reads <param> and <rosparam>: values from attributes, files, programs and YAML."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rostether.errors import LaunchError
from rostether.launch.files import BUILTIN_ROOT, MAX_FILE_BYTES, read_file
from rostether.launch.plan import DeleteParameters, DumpParameters
from rostether.launch.scope import Scope
from rostether.launch.tag_reader import TagReader
from rostether.launch.values import convert, split_words
from rostether.mechanisms.xml_tree import XmlElement
from rostether.names.graph_name import canonical, is_private, join
from rostether.param_yaml import leaves, parse_single_document

_SOURCES = ("value", "textfile", "binfile", "command")
_PARAM_ATTRIBUTES = ("name", "type", *_SOURCES)
_ROSPARAM_ATTRIBUTES = ("command", "ns", "file", "param", "subst_value")
_COMMANDS = ("load", "dump", "delete")
# Launch files run xacro as `$(find xacro)/xacro`, older ones as `$(find xacro)/xacro.py`.
_SCRIPT_SUFFIX = ".py"


class ParameterTags:
    """Reads both tags. All methods raise LaunchError, ConfigError.

    `programs` maps (package, program) to built-in command lines, for packages that are not installed. Without
    `runs_commands`, a parameter with `command=` is an empty string.
    """

    def __init__(
        self, reader: TagReader, programs: Mapping[tuple[str, str], Sequence[str]], *, runs_commands: bool
    ) -> None:
        self._reader = reader
        self._programs = programs
        self._runs_commands = runs_commands

    def param(self, element: XmlElement, scope: Scope) -> None:
        """Set a parameter, or store a private one for the following nodes."""
        name, value = self.name_and_value(element, scope)
        if is_private(name):
            scope.private_params[name] = value
        else:
            self._reader.set_parameter(element, join(scope.namespace, name), value)

    def name_and_value(self, element: XmlElement, scope: Scope) -> tuple[str, Any]:
        """Return the name and value of a <param>; the name may begin with `~`."""
        reader = self._reader
        reader.check_attributes(element, _PARAM_ATTRIBUTES)
        given = {source: reader.optional(element, scope, source) for source in _SOURCES}
        sources = [(source, text) for source, text in given.items() if text is not None]
        if len(sources) != 1:
            raise LaunchError(f"<param> needs one of {', '.join(f'{each}=' for each in _SOURCES)}")
        name = reader.required(element, scope, "name").strip()
        if not name:
            raise LaunchError("<param> has an empty name=; give the parameter a name")
        (source, text), type_name = sources[0], element.attributes.get("type", "").lower().strip() or "auto"
        return name, self._value(source, text, type_name)

    def rosparam(self, element: XmlElement, scope: Scope) -> None:
        """Load parameters, or add a step to the plan that dumps or deletes parameters before the launch."""
        reader = self._reader
        reader.check_attributes(element, _ROSPARAM_ATTRIBUTES)
        command = reader.optional(element, scope, "command") or "load"
        file = reader.optional(element, scope, "file")
        # `ns` is an older name of `param`.
        name = join(
            reader.optional(element, scope, "ns") or "", reader.optional(element, scope, "param") or ""
        )
        replaces = reader.flag(element, scope, "subst_value")
        if is_private(name):
            reader.warn(
                element, f"param={name!r} is not private to the node; write it without ~ inside its <node>"
            )
        full_name = join(scope.namespace, name) if name else scope.namespace
        match command:
            case "load":
                self._load(element, scope, name, full_name, file, replaces=replaces)
            case "dump":
                if not file:
                    raise LaunchError("<rosparam command='dump'> needs file=, the file to write")
                reader.plan.before.append(DumpParameters(canonical(full_name), file))
            case "delete":
                if file is not None:
                    raise LaunchError("<rosparam command='delete'> cannot have file=; remove it")
                reader.plan.before.append(DeleteParameters(canonical(full_name)))
            case _:
                raise LaunchError(f"<rosparam> has no command {command!r}; known: {', '.join(_COMMANDS)}")

    def _load(
        self,
        element: XmlElement,
        scope: Scope,
        name: str,
        full_name: str,
        file: str | None,
        *,
        replaces: bool,
    ) -> None:
        text, source = element.text, "its YAML"
        if file is not None:
            text, source = _read_text(file), file
        if replaces:
            text = self._reader.substitute(text, scope)
        data = parse_single_document(text, source)
        data = {} if data is None else data
        if not name and not isinstance(data, dict):
            raise LaunchError("<rosparam> needs param=, because its value is not a mapping")
        for key, value in leaves(full_name, data):
            self._reader.set_parameter(element, key, value)

    def _value(self, source: str, text: str, type_name: str) -> Any:
        match source:
            case "value":
                return convert(text.strip(), type_name)
            case "textfile":
                return convert(_read_text(text), type_name)
            case "binfile":
                return _read_bytes(text)
        return convert(self._output_of(text), type_name) if self._runs_commands else ""

    def _output_of(self, command: str) -> str:
        words = split_words(command)
        if not words:
            raise LaunchError("<param command=''> is empty; give a command")
        words = [*self._program(words[0]), *words[1:]]
        try:
            with subprocess.Popen(  # noqa: S603 - running it is what command= is for
                words, stdout=subprocess.PIPE, env=dict(self._reader.context.environ)
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
            raise LaunchError(
                f"the command {command!r} failed with code {process.returncode}; run it to see why"
            )
        try:
            return output.decode()
        except UnicodeDecodeError:
            raise LaunchError(
                f"the output of {command!r} is not UTF-8; give a command that prints text"
            ) from None

    def _program(self, word: str) -> Sequence[str]:
        path = Path(word)
        if path.parent.parent == Path(BUILTIN_ROOT):
            built_in = self._programs.get((path.parent.name, path.name.removesuffix(_SCRIPT_SUFFIX)))
            if built_in is None:
                raise LaunchError(f"package {path.parent.name!r} is not installed; install it")
            return built_in
        search_path = self._reader.context.environ.get("PATH")
        if (word, word) in self._programs and shutil.which(word, path=search_path) is None:
            return self._programs[word, word]
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

"""The functions of rosgraph and rosparam that nodes use: the master's API, parameters and their files."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rostether.bounded_yaml import YamlError, load
from rostether.errors import ConfigError
from rostether.param_yaml import parse_documents
from rostether.rospy.client import parameters
from rostether.rospy.client.exceptions import ROSException
from rostether.rospy.client.names import names
from rostether.rospy.tools.graph_names import make_caller_id, make_global_ns, ns_join


class MasterException(Exception):
    """The base of a Master's errors."""


class MasterFailure(MasterException):
    """The master could not execute the call."""


class MasterError(MasterException):
    """The master rejected the call, for example because a name is unknown."""


class RosParamException(Exception):
    """A file or a parameter is invalid."""


class RosParamIOException(RosParamException):
    """The master does not answer."""


@contextmanager
def master_required(kind: type[Exception]) -> Iterator[None]:
    """Raise an error of the class `kind` if the master does not answer in the block."""
    try:
        yield
    except ConnectionRefusedError:
        raise kind("Unable to communicate with master!") from None


class Master:
    """The master's API as methods that return values, with the caller id `caller_id`.

    The methods raise MasterError, MasterFailure, ROSException, and ValueError for an argument that XML-RPC
    cannot carry.
    """

    def __init__(self, caller_id: str, master_uri: str | None = None) -> None:
        self.caller_id = make_caller_id(caller_id).removesuffix("/")
        self.master_uri = master_uri or get_master_uri()
        self._proxy = parameters.MasterProxy(self.master_uri, self.caller_id)

    def is_online(self) -> bool:
        """Return whether the master answers."""
        try:
            self.getPid()
        except (ROSException, MasterException):
            return False
        return True

    def __getattr__(self, method: str) -> Any:
        remote = getattr(self._proxy, method)

        def call(*args: Any) -> Any:
            code, text, value = remote(*args)
            if code == 1:
                return value
            raise MasterError(text) if code == -1 else MasterFailure(text)

        return call


def get_master_uri(env: object = None, argv: object = None) -> str:
    """Return the URI of this program's master; `env` and `argv` have no effect."""
    from rostether.rospy.client.node import node

    return node.environment().master_uri


def is_master_online(master_uri: str | None = None) -> bool:
    """Return whether a master answers."""
    return Master("/rostopic", master_uri).is_online()


def load_file(
    filename: str, default_namespace: str | None = None, verbose: bool = False
) -> list[tuple[Any, str]]:
    """Return each document of a YAML file with its namespace; `-` is standard input.

    Raises RosParamException, OSError.
    """
    if not filename or filename == "-":
        return load_str(sys.stdin.read(), filename, default_namespace)
    if not Path(filename).is_file():
        raise RosParamException(f"file [{filename}] does not exist")
    return load_str(Path(filename).read_text(encoding="utf-8"), filename, default_namespace)


def load_str(
    str: str,
    filename: str,
    default_namespace: str | None = None,
    verbose: bool = False,
) -> list[tuple[Any, str]]:
    """Return each document of a YAML text with its namespace. Raises RosParamException."""
    try:
        documents = list(parse_documents(str, default_namespace or names.namespace, filename))
    except ConfigError as error:
        raise RosParamException(f"{error}") from None
    return [(document, namespace) for namespace, document in documents]


def upload_params(ns: str, values: Any, verbose: bool = False) -> None:
    """Set a parameter, or those of a tree, and keep all others. Raises RosParamException."""
    if ns == "/" and not isinstance(values, dict):
        raise RosParamException("global / can only be set to a dictionary")
    set_param_raw(ns, values)


def set_param(param: str, value: str, verbose: bool = False) -> None:
    """Set a parameter to the value of a YAML text. Raises RosParamException."""
    try:
        set_param_raw(param, load(value))
    except YamlError as error:
        raise RosParamException(f"{param}: the value is {error}") from None


def set_param_raw(param: str, value: Any, verbose: bool = False) -> None:
    """Set a parameter, or those of a tree, and keep all others. Raises RosParamException."""
    if not isinstance(value, dict):
        with master_required(RosParamIOException):
            try:
                parameters.set_param(param, value)
            except ValueError as error:
                raise RosParamException(f"{param}: {error}") from None
        return
    for name, each in value.items():
        if not isinstance(name, str):
            raise RosParamException(
                f"YAML dictionaries must have string keys. Invalid dictionary is:\n{value}"
            )
        set_param_raw(ns_join(param, name), each)


def dump_params(filename: str, param: str, verbose: bool = False) -> None:
    """Write parameters to a YAML file, or to standard output. Raises RosParamException, OSError."""
    import yaml

    text = yaml.dump(get_param(param))
    if filename:
        Path(filename).write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)


def get_param(param: str) -> Any:
    """Return a parameter's value. Raises RosParamException."""
    try:
        with master_required(RosParamIOException):
            return parameters.get_param(param)
    except KeyError:
        raise RosParamException(f"Parameter [{param}] is not set") from None


def delete_param(param: str, verbose: bool = False) -> None:
    """Delete a parameter. Raises MasterError if it is not set, RosParamIOException."""
    try:
        with master_required(RosParamIOException):
            parameters.delete_param(param)
    except KeyError:
        raise MasterError(f"Parameter [{param}] is not set") from None


def list_params(ns: str) -> list[str]:
    """Return the names of the parameters below a namespace, sorted. Raises RosParamIOException."""
    below = make_global_ns(ns)
    with master_required(RosParamIOException):
        return sorted(name for name in parameters.get_param_names() if name.startswith(below))

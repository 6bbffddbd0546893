"""Finds the installed rclpy and the installed packages of message types.

rclpy is loaded when the first node joins: importing it costs half a second. It has no message types: a type
can be used if its package is installed.
"""

from __future__ import annotations

import functools
import os
import sys
import warnings
from importlib import import_module, metadata
from pathlib import Path
from typing import Any, NamedTuple

from rostether.errors import ConfigError, UnknownTypeError
from rostether.extras import install_command
from rostether.mechanisms.text import fold_line
from rostether.msgdef.ros2.action_parts import action_of_part

# The distribution for each major version of rclpy; newer versions belong to `_NEWEST_DISTRIBUTION`.
_DISTRIBUTIONS = {"3": "humble", "4": "iron", "7": "jazzy", "9": "kilted"}
_NEWEST_DISTRIBUTION = "rolling"

# The folder of a ROS 2 installation with a file for each middleware.
_MIDDLEWARES = "share/ament_index/resource_index/rmw_typesupport"

# Parts of actions that are attributes of the action's `Impl`.
_ACTION_PARTS = {
    "SendGoal": "SendGoalService",
    "GetResult": "GetResultService",
    "FeedbackMessage": "FeedbackMessage",
}


class Rclpy(NamedTuple):
    """The modules of rclpy that a graph uses."""

    context: Any
    node: Any
    executors: Any
    callback_groups: Any
    qos: Any
    events: Any
    parameter: Any
    serialization: Any
    task: Any
    duration: Any


@functools.cache
def load_rclpy() -> Rclpy:
    """Import rclpy. Raises ConfigError with the command that installs it."""
    _check_middleware()
    try:
        with warnings.catch_warnings():
            # Users cannot act on these warnings: rosidl's parser uses modules that Python will remove.
            warnings.simplefilter("ignore")
            import_module("rosidl_generator_py")
            modules = {name: import_module(f"rclpy.{name}") for name in Rclpy._fields if name != "events"}
            return Rclpy(events=_import_events(), **modules)
    except ImportError as error:
        raise ConfigError(
            f"rclpy cannot be used ({fold_line(str(error))}); run: {install_command('rclpy')}; or source "
            "the setup file of ROS 2, or use zenoh, which needs neither"
        ) from error


def _check_middleware() -> None:
    """Raise ConfigError if RMW_IMPLEMENTATION is not installed: rcl would end the process at the import."""
    wanted = os.environ.get("RMW_IMPLEMENTATION")
    prefixes = [sys.prefix, *os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)]
    installed = {
        each.name for prefix in prefixes if prefix for each in Path(prefix, _MIDDLEWARES).glob("rmw_*")
    }
    installed.discard("rmw_implementation")
    if wanted and installed and wanted not in installed:
        raise ConfigError(
            f"RMW_IMPLEMENTATION={wanted} is not installed for this rclpy; unset the variable, or set it to "
            f"{' or '.join(sorted(installed))}"
        )


@functools.cache
def interface_class(name: str) -> Any:
    """Return the Python class of `pkg/msg/Name`, `pkg/srv/Name` or a part of an action, `pkg/action/A_Goal`.

    Raises UnknownTypeError if it is not installed.
    """
    package, kind, short = name.split("/")
    try:
        module = import_module(f"{package}.{kind}")
        if kind == "action":
            return _part_of_action(module, short)
        return getattr(module, short)
    except ModuleNotFoundError as error:
        if error.name not in (package, f"{package}.{kind}"):
            raise _not_usable(name, error) from error
        raise UnknownTypeError(
            f"rclpy cannot use {name}: the package {package} is not installed for this Python; build and "
            "source the workspace that contains it, or use zenoh, which reads .msg files"
        ) from None
    except ImportError as error:
        raise _not_usable(name, error) from error
    except AttributeError:
        raise UnknownTypeError(
            f"rclpy cannot use {name}: the installed package {package} does not contain it; build and "
            "source a newer one, or use zenoh, which reads .msg files"
        ) from None


def _part_of_action(module: Any, name: str) -> Any:
    action = action_of_part(name)
    part = name.removeprefix(f"{action}_")
    found = getattr(module, action)
    return getattr(found.Impl, _ACTION_PARTS[part]) if part in _ACTION_PARTS else getattr(found, part)


def _not_usable(name: str, error: ImportError) -> UnknownTypeError:
    return UnknownTypeError(
        f"rclpy cannot use {name}: its package cannot be imported ({fold_line(str(error))}); build it "
        "again for this ROS 2, or use zenoh, which reads .msg files"
    )


def rclpy_distribution() -> str:
    """Return the ROS 2 distribution of the installed rclpy; empty if its version is unknown."""
    try:
        version = metadata.version("rclpy")
    except metadata.PackageNotFoundError:
        return ""
    return _DISTRIBUTIONS.get(version.partition(".")[0], _NEWEST_DISTRIBUTION)


def _import_events() -> Any:
    try:
        return import_module("rclpy.event_handler")
    except ModuleNotFoundError:
        # The name of the module in Humble.
        return import_module("rclpy.qos_event")

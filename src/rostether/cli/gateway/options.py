"""Options of the gateways for web pages and viewers: `serve --rosbridge [HOST:PORT]` and its like."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

import click

from rostether.cli.access.options import Function
from rostether.errors import ConfigError

ROSBRIDGE_OPTION = "--rosbridge"
FOXGLOVE_OPTION = "--foxglove"
OPTIONS_WITH_PLACES = (ROSBRIDGE_OPTION, FOXGLOVE_OPTION)
DEFAULT_PLACE = "localhost"
TOKEN_VARIABLE = "ROSTETHER_TOKEN"  # noqa: S105 - the name of a variable

_KEY = "rostether.gateway_options"
_PLACE = re.compile(r"(?:[\w.-]+:|\[[\da-fA-F:.]+\]:)?\d{1,5}")
_MAX_PORT = 65535
_ORIGIN = re.compile(r"\*|null|[a-zA-Z][\w+.-]*://[^/\s]*/?")


@dataclass(frozen=True, slots=True)
class GatewayOptions:
    """What was typed: a place for each gateway that is wanted (None: not wanted), and who may use them.

    `wider` is what people type, with {port}, to let other machines connect.
    """

    rosbridge: str | None = None
    token: str = ""
    origins: tuple[str, ...] = ()
    allow: tuple[str, ...] = ()
    wider: str = "--rosbridge 0.0.0.0:{port}"
    foxglove: str | None = None

    @property
    def is_any_wanted(self) -> bool:
        """Whether there is a gateway at all."""
        return self.rosbridge is not None or self.foxglove is not None


def with_places(arguments: list[str], known: Collection[str]) -> list[str]:
    """Give gateways' options that stand alone their value: the word behind counts if it is [HOST:]PORT."""
    end = arguments.index("--") if "--" in arguments else len(arguments)
    named: list[str] = []
    for index, each in enumerate(arguments):
        if each in OPTIONS_WITH_PLACES and each in known and index < end:
            following = arguments[index + 1] if index + 1 < end else ""
            if not _PLACE.fullmatch(following):
                named.append(f"{each}={DEFAULT_PLACE}")
                continue
        named.append(each)
    return named


def read_place(text: str, default_port: int) -> tuple[str, int]:
    """Return the host and port of `HOST:PORT`, `PORT` or `HOST`. Raises ConfigError."""
    host, colon, port = text.rpartition(":")
    if text.isdecimal():
        host, port = DEFAULT_PLACE, text
    elif not colon or text.endswith("]") or (text.count(":") > 1 and not text.startswith("[")):
        host, port = text, str(default_port)
    if not port.isdecimal() or len(port) > 20 or not 0 <= int(port) <= _MAX_PORT:
        raise ConfigError(f"{text!r} is no place to listen on: write HOST:PORT, as 0.0.0.0:{default_port}")
    return host.strip("[]"), int(port)


def _keep(context: click.Context, parameter: click.Parameter, value: object) -> object:
    context.meta.setdefault(_KEY, {})[parameter.name] = value
    return value


_ACCESS_OPTIONS = (
    click.option(
        "--token",
        default="",
        metavar="TOKEN",
        envvar=TOKEN_VARIABLE,
        expose_value=False,
        callback=_keep,
        help=f"What web clients must know, as ws://HOST:PORT/?token=TOKEN; or in {TOKEN_VARIABLE}.",
    ),
    click.option(
        "--origin",
        "origins",
        multiple=True,
        metavar="URL",
        expose_value=False,
        callback=_keep,
        help="A web page of another host that may connect, as https://panel.example; null: pages opened from "
        "a file; *: all; may be repeated.",
    ),
)
_PLACE_OPTIONS = (
    click.option(
        ROSBRIDGE_OPTION,
        metavar="[HOST:PORT]",
        expose_value=False,
        callback=_keep,
        help="Serve web pages with roslibjs, as rosbridge does (localhost:9090).",
    ),
    click.option(
        FOXGLOVE_OPTION,
        metavar="[HOST:PORT]",
        expose_value=False,
        callback=_keep,
        help="Serve Foxglove, as foxglove_bridge does (localhost:8765).",
    ),
)


def access_options(function: Function) -> Function:
    """Add --token and --origin; `read_gateway_options` returns what was typed."""
    for option in reversed(_ACCESS_OPTIONS):
        function = option(function)
    return function


def gateway_options(function: Function) -> Function:
    """Add an option for each gateway, and who may use them; `read_gateway_options` returns what was typed."""
    function = access_options(function)
    for option in reversed(_PLACE_OPTIONS):
        function = option(function)
    return function


def read_gateway_options(allow: tuple[str, ...] = ()) -> GatewayOptions:
    """Return what was typed; `allow` are the networks of the command's --allow. Raises ConfigError."""
    context = click.get_current_context(silent=True)
    typed = context.meta.get(_KEY) if context is not None else None
    options = GatewayOptions(**(typed or {}), allow=allow)
    for origin in options.origins:
        if not _ORIGIN.fullmatch(origin):
            raise ConfigError(
                f"--origin: no page is of {origin!r}; write what its address begins with, such as "
                "https://panel.example or http://192.168.1.7:8000"
            )
    return options

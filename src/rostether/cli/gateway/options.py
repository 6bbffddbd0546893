"""Options of the gateways for web pages and viewers, such as `serve --rosbridge [HOST:PORT]`."""

from __future__ import annotations

import os
import re
from functools import partial
from pathlib import Path

from msgspec import Struct

from rostether.cli.shell.option_group import Decorator, OptionalValueOption, add_option, option_group
from rostether.errors import ConfigError
from rostether.ports.config_paths import certificates_folder

DEFAULT_ADDRESS = "localhost"
TOKEN_VARIABLE = "ROSTETHER_TOKEN"  # noqa: S105 - the name of a variable
VIEW_TOKEN_VARIABLE = "ROSTETHER_VIEW_TOKEN"  # noqa: S105 - the name of a variable

_ADDRESS = re.compile(
    r"(?:[\w.-]+:|\[[\da-fA-F:.]+\]:)?\d{1,5}|localhost|\d{1,3}(?:\.\d{1,3}){3}|\[[\da-fA-F:.]+\]"
)
_MAX_PORT = 65535
_ORIGIN = re.compile(r"\*|null|[a-zA-Z][\w+.-]*://[^/\s]*/?")

_HEADING = "Web clients"

AUTO = "auto"


class GatewayOptions(Struct, frozen=True):
    """The options as given: the address of each requested gateway (None: not requested), and who may use it.

    Raises ConfigError for an invalid origin, and for a view token without a different token.
    """

    rosbridge: str | None = None
    token: str = ""
    origins: tuple[str, ...] = ()
    allow: tuple[str, ...] = ()
    foxglove: str | None = None
    view_token: str = ""
    tls: str = ""

    def __post_init__(self) -> None:
        for origin in self.origins:
            if not _ORIGIN.fullmatch(origin):
                raise ConfigError(
                    f"--origin: {origin!r} is not an origin; write it like https://panel.example or "
                    "http://192.168.1.7:8000"
                )
        if self.view_token and not self.token:
            raise ConfigError("--view-token needs --token: without one, every client may do everything")
        if self.view_token and self.view_token == self.token:
            raise ConfigError("--view-token and --token must differ")


NO_OPTIONS = GatewayOptions()


def is_listen_address(word: str) -> bool:
    """Return whether a word is [HOST:]PORT or an IP address: the value of the option before it."""
    return _ADDRESS.fullmatch(word) is not None


def read_listen_address(text: str, default_port: int) -> tuple[str, int]:
    """Return the host (default: loopback) and port of `HOST:PORT`, `PORT` or `HOST`. Raises ConfigError."""
    host, colon, port = text.rpartition(":")
    if text.isdecimal():
        host, port = DEFAULT_ADDRESS, text
    elif not colon or text.endswith("]") or (text.count(":") > 1 and not text.startswith("[")):
        host, port = text, str(default_port)
    if not port.isdecimal() or len(port) > len(str(_MAX_PORT)) or int(port) > _MAX_PORT:
        raise ConfigError(
            f"{text!r} is not an address to listen on; write HOST:PORT, e.g. 0.0.0.0:{default_port}"
        )
    return host.strip("[]") or DEFAULT_ADDRESS, int(port)


_CLIENT_OPTIONS = (
    add_option(
        "--token TOKEN",
        f"Require this token from web clients: ws://HOST:PORT/?token=TOKEN; or set {TOKEN_VARIABLE}.",
        default="",
        envvar=TOKEN_VARIABLE,
    ),
    add_option(
        "--origin origins URL",
        "Accept web pages of this origin, e.g. https://panel.example; null: pages opened from a file; "
        "*: all; may be repeated.",
        multiple=True,
    ),
)
_ACCESS_OPTIONS = (
    *_CLIENT_OPTIONS,
    add_option(
        "--tls",
        "Encrypt: auto makes a certificate for this machine; or give a PEM file with certificate and key.",
        default="",
        metavar="auto|FILE",
    ),
)
_VIEW_OPTIONS = (
    add_option(
        "--view-token TOKEN",
        "A second token, for clients that may only view, not publish, call or set; or set "
        f"{VIEW_TOKEN_VARIABLE}.",
        default="",
        envvar=VIEW_TOKEN_VARIABLE,
    ),
)


def _address_option(spelling: str, text: str) -> Decorator:
    return add_option(
        f"{spelling} [HOST:PORT]",
        text,
        cls=OptionalValueOption,
        alone=DEFAULT_ADDRESS,
        is_value=is_listen_address,
        heading=_HEADING,
    )


dashboard_option = _address_option(
    "--dashboard", "Serve the dashboard, a page for browsers (default: 127.0.0.1:8765)."
)
_ADDRESS_OPTIONS = (
    _address_option(
        "--rosbridge", "Serve web pages with roslibjs, as rosbridge does (default: localhost:9090)."
    ),
    _address_option("--foxglove", "Serve Foxglove, as foxglove_bridge does (default: localhost:8765)."),
)


def _client_group(*options: Decorator) -> Decorator:
    # --allow is an option of the graph.
    return option_group("gateways", partial(GatewayOptions, allow=()), options, heading=_HEADING)


# Adds --token and --origin, for nodes with parameters for TLS; the verb gets a GatewayOptions as `gateways`.
client_options = _client_group(*_CLIENT_OPTIONS)
# Also adds --tls.
access_options = _client_group(*_ACCESS_OPTIONS)
# Also adds --view-token, for gateways with view-only clients.
viewer_access_options = _client_group(*_ACCESS_OPTIONS, *_VIEW_OPTIONS)
# Adds an option for each gateway as well.
gateway_options = _client_group(*_ADDRESS_OPTIONS, *_ACCESS_OPTIONS, *_VIEW_OPTIONS)


class Encryption(Struct, frozen=True):
    """The files of a gateway's certificate, empty without encryption; other devices install `authority`."""

    certificate: str = ""
    key: str = ""
    authority: Path | None = None


def read_encryption(typed: str, host: str) -> Encryption:
    """Return the files that `--tls` means; `host` is where the gateway listens.

    Makes this machine's certificate if needed, which takes a moment. Raises ConfigError.
    """
    if not typed:
        return Encryption()
    if typed != AUTO:
        return Encryption(typed)
    from rostether.gateways.websocket.own_authority import own_certificate

    names = (host, os.environ.get("ROS_HOSTNAME", ""), os.environ.get("ROS_IP", ""))
    made = own_certificate(certificates_folder(), names)
    return Encryption(str(made.certificate), str(made.key), made.authority)

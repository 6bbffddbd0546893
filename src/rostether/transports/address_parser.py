"""Reads link addresses as users type them: the scheme, the path or the endpoint, and the options.

    /dev/ttyACM0    /dev/ttyUSB0?baud=115200&reset=no    COM3    serial:/tmp/tty
    tcp://:11411    tcp://0.0.0.0:11411?allow=192.168.1.0/24    tcp://robot.local:11411?connect=yes
    tcp://:11411?psk=key.txt    tls://:11412?cert=server.pem&key=server.key&ca=boards.pem
    udp://:11411    udp://192.168.1.7:11411?connect=yes&bind=11411
    pty:/tmp/board  xbee:/dev/ttyUSB0?baud=57600&peers=1,2,0013A20040A1B2C3
    sim:blink.ino?board=uno&adc=A0:2.5&range=0.5
    web:    web:?ns=lab

An empty host is loopback. Every address accepts `name=` and `ns=`, the board's node name and namespace.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from rostether.errors import ConfigError
from rostether.mechanisms.loopback import LOOPBACK
from rostether.transports.address import (
    DEFAULT_BAUD,
    DEFAULT_PORT,
    Address,
    PtyAddress,
    SerialAddress,
    SimAddress,
    TcpAddress,
    TlsFiles,
    UdpAddress,
    WebAddress,
    XbeeAddress,
)
from rostether.transports.address_advice import MAX_PORT, WINDOWS_PORT, address_advice, is_number
from rostether.transports.allow_list import check_networks
from rostether.transports.xbee.radio_address import parse_radio_address

# No USB bridge has a faster UART; the limit detects a typing error.
MAX_BAUD = 20_000_000
# A Mega has four.
MAX_UART = 3
# More seeds than anyone tries; the simulator reads numbers of 64 bits.
MAX_SEED = 2**32 - 1

# The options of a simulated board that are commands of that board.
_SIM_COMMANDS = (
    "adc",
    "aref",
    "attitude",
    "autoreset",
    "battery",
    "fault",
    "hcsr04",
    "network",
    "pin",
    "range",
    "servo",
    "w5100",
    "watch",
    "wheels",
)
# Commands whose values are separated by spaces; those of the others are separated by commas.
_SPACE_SEPARATED = ("adc", "attitude", "pin", "servo", "watch")
# Commands whose values are settings such as A0=2.5.
_WITH_SETTINGS = ("adc", "fault", "hcsr04", "pin", "w5100", "wheels")

_COMMON_OPTIONS = ("name", "ns")
_KNOWN_OPTIONS = {
    "serial": ("baud", "reset"),
    "tcp": ("connect", "allow", "psk"),
    "tls": ("connect", "allow", "psk", "cert", "key", "ca"),
    "udp": ("connect", "bind", "allow"),
    "pty": (),
    "xbee": ("baud", "peers"),
    "sim": ("board", "baud", "uart", "seed", *_SIM_COMMANDS),
    "web": (),
}
_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):(.*)", re.DOTALL)
_YES = ("yes", "true", "on", "1")
_NO = ("no", "false", "off", "0")


def parse_address(text: str) -> Address:
    """Read a link address. Raises ConfigError with what to write instead."""
    if not text.strip().isprintable():
        raise ConfigError(f"link address {text!r} has invisible characters; type it again")
    address, _, query = text.strip().partition("?")
    scheme, rest = _split_scheme(address)
    options = _parse_options(text, scheme, query)
    name, ns = options.pop("name", None), options.pop("ns", None)
    reader = _Options(text, options)
    match scheme:
        case "serial":
            path, reset = _require_path(text, rest), reader.flag("reset", default=True)
            return SerialAddress(path, reader.baud(), reset, name=name, ns=ns, given=tuple(options))
        case "tcp" | "tls":
            host, port = _parse_endpoint(text, rest)
            connect, networks, psk = reader.flag("connect"), reader.networks(), options.get("psk")
            tls = TlsFiles(*map(options.get, ("cert", "key", "ca"))) if scheme == "tls" else None
            return TcpAddress(host, port, connect, networks, psk, tls, name=name, ns=ns)
        case "udp":
            host, port = _parse_endpoint(text, rest)
            connect, bind = reader.flag("connect"), reader.bind_port()
            return UdpAddress(host, port, connect, bind, reader.networks(), name=name, ns=ns)
        case "pty":
            return PtyAddress(_require_path(text, rest), name=name, ns=ns)
        case "xbee":
            path, peers = _require_path(text, rest), reader.xbee_peers()
            return XbeeAddress(path, reader.baud(), peers, name=name, ns=ns)
        case "web":
            if rest:
                raise ConfigError(
                    f"link address {text!r} has text after web:; write only web:, as pages connect boards"
                )
            return WebAddress(name=name, ns=ns)
        case _:
            # Checked as for a serial port, but not used: a simulated UART has the sketch's baud rate.
            reader.baud()
            path, board = _require_path(text, rest), options.get("board", "uno")
            commands = _sim_commands(options)
            return SimAddress(path, board, commands, reader.uart(), reader.seed(), name=name, ns=ns)


class _Options:
    def __init__(self, address: str, values: dict[str, str]) -> None:
        self._address = address
        self._values = values

    def flag(self, key: str, *, default: bool = False) -> bool:
        value = self._values.get(key)
        if value is None:
            return default
        if value.lower() not in (*_YES, *_NO):
            raise ConfigError(f"{key}={value} in link address {self._address!r}: write {key}=yes or {key}=no")
        return value.lower() in _YES

    def baud(self) -> int:
        return self._number("baud", DEFAULT_BAUD, 1, MAX_BAUD)

    def bind_port(self) -> int:
        return self._number("bind", 0, 0, MAX_PORT)

    def uart(self) -> int | None:
        return self._number("uart", 0, 0, MAX_UART) if "uart" in self._values else None

    def seed(self) -> int:
        return self._number("seed", 0, 0, MAX_SEED)

    def networks(self) -> tuple[str, ...]:
        value = self._values.get("allow")
        if value is None:
            return ()
        return check_networks(value.split(","), f"allow={value} in link address {self._address!r}")

    def xbee_peers(self) -> tuple[int, ...]:
        value = self._values.get("peers")
        if value is None:
            return ()
        peers = [parse_radio_address(peer) for peer in value.split(",")]
        known = tuple(dict.fromkeys(peer for peer in peers if peer is not None))
        if len(known) < len(peers):
            raise ConfigError(
                f"peers={value} in link address {self._address!r}: write each radio once, separated by "
                "commas, with its 16-bit address or the address on its label: peers=1,0x2a,0013A20040A1B2C3"
            )
        return known

    def _number(self, key: str, default: int, lowest: int, highest: int) -> int:
        value = self._values.get(key)
        if value is None:
            return default
        if not (is_number(value) and lowest <= int(value) <= highest):
            raise ConfigError(
                f"{key}={value} in link address {self._address!r}: write a number from {lowest} to {highest}"
            )
        return int(value)


def _split_scheme(address: str) -> tuple[str, str]:
    match = _SCHEME.fullmatch(address)
    if match and match[1].lower() in _KNOWN_OPTIONS:
        return match[1].lower(), match[2]
    if WINDOWS_PORT.fullmatch(address) or ("/" in address and match is None):
        return "serial", address
    if not address:
        raise ConfigError("empty link address; write for instance /dev/ttyACM0 or tcp://:11411")
    if address.lower() in _KNOWN_OPTIONS:
        scheme = address.lower()
        help_text = f"see `rostether serve --help` for {scheme}:"
        if scheme in ("tcp", "tls", "udp"):
            help_text = f"write {scheme}://:{DEFAULT_PORT} to listen for boards"
        raise ConfigError(f"not a link address: {address!r}; {help_text}")
    if (advice := address_advice(address)) is not None:
        raise ConfigError(f"not a link address: {address!r}; {advice}")
    kind = match[1] if match else address
    raise ConfigError(
        f"unknown kind of link {kind!r} in address {address!r}; known: a serial port's path, "
        f"{', '.join(f'{known}:' for known in _KNOWN_OPTIONS)}"
    )


def _parse_options(text: str, scheme: str, query: str) -> dict[str, str]:
    known = (*_KNOWN_OPTIONS[scheme], *_COMMON_OPTIONS)
    options: dict[str, str] = {}
    for part in query.split("&") if query else ():
        key, equals, value = part.partition("=")
        if key not in known:
            raise ConfigError(f"unknown option {key!r} in link address {text!r}; known: {', '.join(known)}")
        if not equals or not value:
            raise ConfigError(f"option {key!r} in link address {text!r} has no value; write {key}=VALUE")
        if key in options:
            raise ConfigError(f"option {key!r} is given twice in link address {text!r}; keep one")
        options[key] = value
    return options


def _require_path(text: str, rest: str) -> str:
    path = rest.strip()
    path = path.removeprefix("//") if path.startswith("///") else path
    if not path:
        raise ConfigError(
            f"link address {text!r} has no path; write one such as /dev/ttyACM0 or sim:blink.ino"
        )
    return path


def _parse_endpoint(text: str, rest: str) -> tuple[str, int]:
    endpoint = rest.removeprefix("//").rstrip("/")
    if endpoint.startswith("["):
        host, bracket, after = endpoint[1:].partition("]")
        if not bracket or (after and not after.startswith(":")):
            raise ConfigError(f"malformed IPv6 address in link address {text!r}; write [::1]:{DEFAULT_PORT}")
        port_text = after[1:]
    else:
        host, _, port_text = endpoint.partition(":")
        if is_number(host) and not port_text:
            meant = f"{text.partition(':')[0]}://:{host}"
            raise ConfigError(f"link address {text!r} has no host; write {meant} to listen on that port")
    if not port_text:
        port_text = str(DEFAULT_PORT)
    if not (is_number(port_text) and int(port_text) <= MAX_PORT):
        raise ConfigError(
            f"{port_text!r} in link address {text!r} is not a port; write HOST:PORT with a number up to "
            f"{MAX_PORT}"
        )
    if any(character in "/[]" or character.isspace() for character in host):
        raise ConfigError(f"host {host!r} in link address {text!r} is not a host name; write HOST:PORT")
    return host or LOOPBACK, int(port_text)


def _sim_commands(options: Mapping[str, str]) -> tuple[str, ...]:
    """Return the commands for a simulated board from an address's options, in the same order.

    In an address `=` and `&` separate options, so a `=` within a value is written `:`, and a space as a
    comma. `adc=A0:2.5,A1:1` is the command `adc A0=2.5 A1=1`, and `fault=to:flip:0.01,seed:3` is the command
    `fault to:flip=0.01,seed=3`.
    """
    return tuple(_sim_command(key, value) for key, value in options.items() if key in _SIM_COMMANDS)


def _sim_command(key: str, value: str) -> str:
    parts = value.split(",")
    if key in _WITH_SETTINGS:
        parts = ["=".join(part.rsplit(":", 1)) for part in parts]
    return f"{key} {(' ' if key in _SPACE_SEPARATED else ',').join(parts)}"

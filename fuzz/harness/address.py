"""Link addresses: refused in one line, or read as an address within its limits; its text is valid again."""

from __future__ import annotations

import random

from fuzz.grammar import near
from rostether.errors import RostetherError
from rostether.transports.address import (
    Address,
    SerialAddress,
    SimAddress,
    TcpAddress,
    UdpAddress,
    XbeeAddress,
)
from rostether.transports.address_parser import MAX_BAUD, MAX_SEED, MAX_UART, parse_address
from rostether.transports.xbee.radio_address import BROADCAST_ADDRESS, MAX_SHORT_ADDRESS

_MAX_PORT = 65535


def seeds() -> list[bytes]:
    """Return addresses of every kind."""
    return [
        b"/dev/ttyACM0?baud=115200&reset=no&name=arm&ns=/lab",
        b"tcp://0.0.0.0:11411?allow=192.168.1.0/24,fe80::/10",
        b"udp://[::1]:11411?connect=yes&bind=1",
        b"tls://:11412?cert=a.pem&key=a.key&ca=b.pem&psk=key.txt",
        b"pty:/tmp/a",
        b"xbee:/dev/ttyUSB0?peers=1,0x2a,0013A20040A1B2C3",
        b"sim:blink.ino?board=uno&adc=A0:2.5&uart=1&seed=7",
        b"COM3",
    ]


def generate(source: random.Random) -> bytes:
    """Return an address with numbers near their limits, sometimes with thousands of digits."""
    port = _number(source, _MAX_PORT)
    place, keys = source.choice(
        (
            ("/dev/ttyACM0", ("baud", "reset", "name")),
            (f"tcp://{source.choice(('', 'host', '10.0.0.1', '[::1]', 'a b'))}:{port}", ("connect", "allow")),
            (f"udp://:{port}", ("connect", "bind", "allow")),
            ("xbee:/dev/ttyUSB0", ("baud", "peers")),
            ("sim:blink.ino", ("board", "uart", "seed", "adc")),
            (source.choice(("pty:/tmp/a", "ftp:x", "host:1", "")), ("name",)),
        )
    )
    options = []
    for key in source.sample(keys, source.randint(0, len(keys))):
        limits = {"baud": MAX_BAUD, "bind": _MAX_PORT, "peers": MAX_SHORT_ADDRESS, "uart": MAX_UART}
        value = source.choice(("yes", "no", "maybe", "", "10.0.0.0/8", "1,2", "A0:2.5"))
        if key in (*limits, "seed"):
            value = _number(source, limits.get(key, MAX_SEED))
        options.append(f"{key}={value}")
    return (place + ("?" + "&".join(options) if options else "")).encode()


def _number(source: random.Random, limit: int) -> str:
    # Python reads no number of more than 4300 digits.
    return "9" * 5000 if source.random() < 0.05 else str(near(source, limit))


def run(data: bytes) -> None:
    """Read an address, and read its own text again."""
    try:
        address = parse_address(data.decode("utf-8", "replace"))
    except RostetherError as error:
        assert "\n" not in str(error), error
        return
    _check(address)
    again = parse_address(str(address))
    assert type(again) is type(address)


def _check(address: Address) -> None:
    match address:
        case SerialAddress():
            assert 1 <= address.baud <= MAX_BAUD, "a speed that no port has"
        case XbeeAddress():
            assert 1 <= address.baud <= MAX_BAUD, "a speed that no port has"
            assert all(_is_radio_address(peer) for peer in address.peers), "not the address of a peer"
        case TcpAddress():
            assert 0 <= address.port <= _MAX_PORT, "not a port number"
        case UdpAddress():
            assert 0 <= address.port <= _MAX_PORT, "not a port number"
            assert 0 <= address.bind <= _MAX_PORT, "not a port number"
        case SimAddress():
            assert address.uart is None or 0 <= address.uart <= MAX_UART
            assert 0 <= address.seed <= MAX_SEED


def _is_radio_address(address: int) -> bool:
    return 0 <= address <= MAX_SHORT_ADDRESS or BROADCAST_ADDRESS < address < 2**64

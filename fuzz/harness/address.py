"""Link addresses: refused in one line, or an address whose text is one again."""

from __future__ import annotations

from rostether.errors import RostetherError
from rostether.transports.address import parse_address


def seeds() -> list[bytes]:
    """Return addresses of every kind."""
    return [
        b"/dev/ttyACM0?baud=115200&reset=no&name=arm&ns=/lab",
        b"tcp://0.0.0.0:11411?allow=192.168.1.0/24,fe80::/10",
        b"udp://[::1]:11411?connect=yes&bind=1",
        b"tls://:11412?cert=a.pem&key=a.key&ca=b.pem&psk=key.txt",
        b"pty:/tmp/a",
        b"xbee:/dev/ttyUSB0?peers=1,0x2a",
        b"sim:blink.ino?board=uno&adc=A0:2.5&uart=1&seed=7",
        b"COM3",
    ]


def run(data: bytes) -> None:
    """Read an address, and what it calls itself."""
    try:
        address = parse_address(data.decode("utf-8", "replace"))
    except RostetherError as error:
        assert "\n" not in str(error), error
        return
    again = parse_address(str(address))
    assert type(again) is type(address)

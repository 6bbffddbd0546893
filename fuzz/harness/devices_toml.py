"""devices.toml: refused in one line that names file and key, or read within its limits."""

from __future__ import annotations

import ipaddress
import random

from fuzz.grammar import near
from fuzz.lowering import lowered
from rostether.errors import RostetherError
from rostether.ports import toml_table
from rostether.ports.board_identity import BoardIdentity
from rostether.ports.devices_toml import MAX_GRACE_S, MAX_QUEUE_DEPTH, parse_devices_toml
from rostether.transports.address_parser import MAX_BAUD

MAX_ENTRIES = 12


def seeds() -> list[bytes]:
    """Return files."""
    return [
        b'[discovery]\nprobe = ["067b:2303", "all"]\n[defaults]\ngrace_s = 10\nremap = { a = "/b" }\n',
        b'[devices.arm]\nserial_number = "75"\nbaud = 115200\nreset = false\nnamespace = "/lab"\n'
        b'required_topics = ["imu"]\nqueue_depths = { "/a" = 1 }\n[devices.arm.access]\n'
        b'publish = { allow = ["/lab/*"], deny = ["/x"] }\n',
        b'[devices."left/arm"]\naddress = "192.168.1.20"\n'
        b'[devices.b]\nport = "/dev/ttyUSB*"\nusb_id = "2341:0043"\n',
    ]


def generate(source: random.Random) -> bytes:
    """Return boards with some keys, and values near their limits or of a wrong type."""
    lines = []
    for number in range(near(source, MAX_ENTRIES) % 16 if source.random() < 0.2 else source.randint(0, 3)):
        lines.append(f"[devices.b{number}]")
        lines += [f"{key} = {_value(source, key)}" for key in source.sample(_KEYS, source.randint(0, 4))]
    return "\n".join(lines).encode()


_KEYS = (
    "serial_number",
    "address",
    "usb_id",
    "baud",
    "grace_s",
    "queue_depths",
    "namespace",
    "remap",
    "reset",
)


def _value(source: random.Random, key: str) -> str:  # noqa: PLR0911 - one case for each kind of value
    if source.random() < 0.1:
        return source.choice(("9" * 5000, "nan", "[]", "{}", '"x"', "true", "1979-05-27", "-1", "inf"))
    match key:
        case "serial_number":
            return source.choice(('"75"', '"76"', '""'))
        case "address":
            return source.choice(('"10.0.0.7"', '"::1"', '"0:0::1"', '"host"', '"10.0.0.300"'))
        case "usb_id":
            return source.choice(('"2341:0043"', '"2341:00"'))
        case "baud":
            return str(near(source, MAX_BAUD))
        case "grace_s":
            return str(near(source, int(MAX_GRACE_S)) + source.choice((0, 0.5)))
        case "queue_depths":
            count = near(source, MAX_ENTRIES) % 16 if source.random() < 0.3 else 1
            depths = (f'"/t{number}" = {near(source, MAX_QUEUE_DEPTH)}' for number in range(count))
            return "{ " + ", ".join(depths) + " }"
        case "remap":
            return source.choice(('{ a = "/b" }', '{ "a b" = "/b" }', '{ a = "2b" }'))
        case "namespace":
            return source.choice(('"/lab"', '"lab"', '"2lab"', '"/a b"'))
        case _:
            return source.choice(("true", "1", '"no"'))


def run(data: bytes) -> None:
    """Read a file and look up settings."""
    with lowered(toml_table, MAX_ENTRIES=MAX_ENTRIES):
        _parse(data.decode("utf-8", "replace"))


def _parse(text: str) -> None:
    try:
        book = parse_devices_toml(text)
    except RostetherError as error:
        assert "\n" not in str(error)
        return
    marks = [device.match for device in book.devices if device.match is not None]
    assert len(set(marks)) == len(marks), "two boards with the same marks"
    assert len(book.devices) <= MAX_ENTRIES, "more boards than allowed"
    for device in book.devices:
        assert device.baud is None or 1 <= device.baud <= MAX_BAUD, "a speed that no port has"
        assert device.grace_s is None or 0 <= device.grace_s <= MAX_GRACE_S, "a time outside its limits"
        assert len(device.queue_depths) <= MAX_ENTRIES
        assert all(1 <= depth <= MAX_QUEUE_DEPTH for depth in device.queue_depths.values()), (
            "a depth outside its limits"
        )
        if device.match is not None and device.match.address is not None:
            assert device.match.address == str(ipaddress.ip_address(device.match.address))
    settings = book.settings_for("arm", BoardIdentity(port="/dev/ttyUSB0", address="192.168.1.20"))
    settings.access.publish.refusal("/lab/imu")

"""devices.toml: refused in one line that names file and key, or understood."""

from __future__ import annotations

from rostether.devices.board_identity import BoardIdentity
from rostether.devices.devices_toml import parse_devices_toml
from rostether.errors import RostetherError


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


def run(data: bytes) -> None:
    """Read a file and ask for settings."""
    try:
        book = parse_devices_toml(data.decode("utf-8", "replace"))
    except RostetherError as error:
        assert "\n" not in str(error)
        return
    settings = book.settings_for("arm", BoardIdentity(port="/dev/ttyUSB0", address="192.168.1.20"))
    settings.access.publish.permits("/lab/imu")

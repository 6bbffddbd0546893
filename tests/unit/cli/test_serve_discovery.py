"""`serve` without an address, as a process: a board on a pseudo-terminal is found, named and served."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from interop.ros1_peers import free_port
from programs import started
from rostether import Device

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


async def test_serve_without_an_address_looks_for_boards(tmp_path: Path) -> None:
    config = tmp_path / "devices.toml"
    config.write_text(
        f'[discovery]\nignore = ["all"]\n[devices.arm]\nport = "{tmp_path}/ttyACM*"\nnamespace = "/lab"\n'
    )
    uri = f"http://localhost:{free_port()}"
    async with started("serve", "--config", str(config), ROS_MASTER_URI=uri) as serve:
        await serve.wait_for("Looking for boards on the serial ports")
        async with Device(f"pty:{tmp_path}/ttyACM7") as device:
            device.publisher("count", "std_msgs/UInt32")
            await serve.wait_for("Setup publisher on count [std_msgs/UInt32]")
        assert "/lab/arm: Setup publisher" in serve.text
        assert "Traceback" not in serve.text


async def test_a_mistake_in_the_file_is_one_line(tmp_path: Path) -> None:
    config = tmp_path / "devices.toml"
    config.write_text('[devices.arm]\nport = "/dev/ttyACM0"\nbaudrate = 9600\n')
    async with started("serve", "--config", str(config)) as serve:
        text = await serve.finish()
    assert serve.process.returncode == 1
    assert text.startswith(f"rostether: error: {config}:devices.arm.baudrate: unknown key; known: ")
    assert len(text.splitlines()) == 1

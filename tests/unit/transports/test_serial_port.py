from __future__ import annotations

from pathlib import Path

from rostether.transports.serial_port import SerialPort, find_usb_location


def test_the_socket_is_found_in_the_kernel_table(tmp_path: Path) -> None:
    device = tmp_path / "devices/pci0000:00/usb1/1-1/1-1.2/1-1.2:1.0/ttyUSB0"
    device.mkdir(parents=True)
    (tmp_path / "class/ttyUSB0").mkdir(parents=True)
    (tmp_path / "class/ttyUSB0/device").symlink_to(device)
    (tmp_path / "class/ttyS0").mkdir()
    (tmp_path / "class/ttyS0/device").symlink_to(tmp_path / "devices")
    folder = str(tmp_path / "class")
    assert find_usb_location("/dev/ttyUSB0", sys_folder=folder) == "1-1.2:1.0"
    assert find_usb_location("/dev/ttyS0", sys_folder=folder) is None
    assert find_usb_location("/dev/ttyNONE", sys_folder=folder) is None
    assert find_usb_location("COM3", sys_folder=folder) is None


def test_the_usb_id_is_written_in_the_usual_form() -> None:
    assert SerialPort("/dev/x", "", usb_vendor_id=0x1A86, usb_product_id=0x7523).usb_id == "1a86:7523"
    assert SerialPort("/dev/x", "").usb_id is None

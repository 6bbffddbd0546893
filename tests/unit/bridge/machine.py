"""A machine whose serial ports are pseudo-terminals with USB ids and other marks from a test."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from rostether.bridge.ports.found_port import MachinePorts
from rostether.device import Device
from rostether.transports.address import SerialAddress
from rostether.transports.serial import SerialTransport, open_serial
from rostether.transports.serial_port import SerialPort
from unit.bridge.nodes import STORE

UNO: dict[str, Any] = {"usb_vendor_id": 0x2341, "usb_product_id": 0x43, "description": "Arduino Uno"}
CH340: dict[str, Any] = {"usb_vendor_id": 0x1A86, "usb_product_id": 0x7523, "description": "USB Serial"}
MODEM: dict[str, Any] = {"usb_vendor_id": 0x2C7C, "usb_product_id": 0x125, "description": "LTE modem"}


class Machine:
    """The ports; `opens` counts how often the bridge opened each port."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.opens: Counter[str] = Counter()
        self.opened: list[SerialTransport] = []
        self.users: dict[str, str] = {}
        self._ports: dict[str, SerialPort] = {}
        self.ports = MachinePorts(
            self.list_ports, (str(folder),), self._open, lambda path: self.users.get(path)
        )

    def path(self, name: str) -> str:
        """Return the path of a port."""
        return str(self.folder / name)

    def list_ports(self) -> list[SerialPort]:
        """Return the ports, as the system would."""
        return [port for port in self._ports.values() if Path(port.path).exists()]

    def mark(self, name: str, **marks: Any) -> None:
        """Set the marks of the device that will be plugged in at a port."""
        marks.setdefault("description", "serial port")
        self._ports[name] = replace(SerialPort(self.path(name), ""), **marks)

    def board(self, name: str, declare: Callable[[Device], object] | None = None, **marks: Any) -> Device:
        """Return a board that is plugged in until its block ends."""
        self.mark(name, **marks)
        device = Device(f"pty:{self.path(name)}", store=STORE)
        if declare is not None:
            declare(device)
        return device

    async def _open(self, address: SerialAddress) -> SerialTransport:
        self.opens[Path(address.path).name] += 1
        transport = await open_serial(address)
        self.opened.append(transport)
        return transport

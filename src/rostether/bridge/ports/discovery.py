"""Finds boards when they are plugged into serial ports; never opens a port that may be another device."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Awaitable, Callable, Sequence

from rostether.bridge.ports.found_port import THIS_MACHINE, FoundPort, MachinePorts
from rostether.bridge.ports.link_keeper import ServeLink
from rostether.bridge.reporter import Reporter
from rostether.graph.ports import Level
from rostether.ports.device_book import DeviceBook
from rostether.ports.known_boards import KnownBoards
from rostether.ports.port_policy import PortUse, identify, port_use
from rostether.ports.port_watch import PortWatch
from rostether.ports.usb_boards import board_of
from rostether.transports.serial_port import SerialPort

# The limit of remembered ports that were reported as not opened; no machine has more.
MAX_OFFERS = 256


class Discovery:
    """The search for boards on this machine's serial ports.

    `excluded` are paths that are already served. `run` never ends by itself; `spawn` creates its tasks.
    """

    def __init__(
        self,
        *,
        devices: DeviceBook,
        known: KnownBoards,
        serve: ServeLink,
        spawn: Callable[[Awaitable[object]], asyncio.Task[None]],
        reporter: Reporter,
        excluded: Sequence[str] = (),
        ports: MachinePorts = THIS_MACHINE,
    ) -> None:
        self._devices = devices
        self._known = known
        self._serve = serve
        self._spawn = spawn
        self._reporter = reporter
        self._excluded = tuple(excluded)
        self._ports = ports
        marked = [device.match.port for device in devices.devices if device.match is not None]
        entries = (*devices.discovery.probe, *(port for port in marked if port is not None))
        self._watch = PortWatch(ports.list_ports, entries=entries, folders=ports.folders)
        self._kept: dict[str, tuple[FoundPort, asyncio.Task[None]]] = {}
        self._present: dict[str, SerialPort] = {}
        self._offered: set[str] = set()

    async def run(self) -> None:
        """Watch the ports until canceled."""
        self._reporter.report(Level.INFO, "Looking for boards on the serial ports")
        is_first = True
        async for ports in self._watch.changes():
            self._update(ports)
            if is_first and not self._kept:
                self._reporter.report(
                    Level.INFO, "No known board is plugged in yet; `rostether ports` lists all ports"
                )
            is_first = False

    def _update(self, ports: Sequence[SerialPort]) -> None:
        present = self._present = {port.path: port for port in ports}
        moved = {identify(port).key for port in ports}
        for path, (found, task) in list(self._kept.items()):
            is_here = self._is_here(found.port)
            if is_here and found.is_dismissed:
                continue
            # A served board that has left is kept until its task has reported why and ended. If the board is
            # already back at another port, its task is canceled.
            has_left = not is_here and (not found.is_serving or found.identity.key in moved)
            if has_left or task.done() or (path in present and not is_here):
                task.cancel()
                del self._kept[path]
        excluded = {os.path.realpath(path) for path in self._excluded}
        for port in ports:
            if port.path not in self._kept and os.path.realpath(port.path) not in excluded:
                self._consider(port)

    def _is_here(self, port: SerialPort) -> bool:
        """Return whether a port is still there, with the same board."""
        now = self._present.get(port.path)
        return now is not None and identify(now).key == identify(port).key

    def _consider(self, port: SerialPort) -> None:
        settings = self._devices.settings_matching(identify(port))
        choice = port_use(port, settings, self._devices.discovery)
        if choice is PortUse.LEAVE:
            return
        if choice is PortUse.OFFER:
            self._offer(port)
            return
        found = FoundPort(
            port,
            choice,
            settings,
            ports=self._ports,
            is_present=self._is_here,
            serve=self._serve,
            known=self._known,
            reporter=self._reporter,
        )
        self._kept[port.path] = found, self._spawn(found.run())

    def _offer(self, port: SerialPort) -> None:
        key = identify(port).key
        if key in self._offered or len(self._offered) >= MAX_OFFERS:
            return
        self._offered.add(key)
        what = board_of(port.usb_vendor_id, port.usb_product_id) or port.description
        self._reporter.report(
            Level.INFO,
            f"{port.path} ({what}) is not opened: it may be any device; if it is a board, add --probe "
            f"{port.usb_id}",
        )

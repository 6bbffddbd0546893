"""Finds the settings of a board."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from rostether.ports.board_identity import BoardIdentity
from rostether.ports.port_pattern import fits_port
from rostether.ports.settings import NO_SETTINGS, DeviceMatch, DeviceSettings, DiscoverySettings
from rostether.transports.board_keys import NO_KEYS, BoardKeys, read_board_keys


class DeviceBook:
    """The boards in devices.toml, and the settings of all others (`defaults`)."""

    def __init__(
        self,
        devices: Sequence[DeviceSettings] = (),
        *,
        defaults: DeviceSettings = NO_SETTINGS,
        discovery: DiscoverySettings | None = None,
    ) -> None:
        self.devices = tuple(devices)
        self.defaults = defaults
        self.discovery = discovery if discovery is not None else DiscoverySettings()

    def board_keys(self) -> BoardKeys:
        """Read the keys and certificates of individual boards from their files. Raises ConfigError."""
        matches = [device.match for device in self.devices if device.match is not None]
        keys = [match.psk for match in matches if match.psk is not None]
        certificates = [match.certificate for match in matches if match.certificate is not None]
        if not keys and not certificates:
            return NO_KEYS
        return read_board_keys(keys, certificates)

    def settings_matching(self, identity: BoardIdentity) -> DeviceSettings:
        """Return the settings of the first matching device in the file, else the defaults."""
        for device in self.devices:
            if device.match is not None and fits(device.match, identity):
                return device
        return self.defaults

    def settings_for(self, node_name: str | None, identity: BoardIdentity) -> DeviceSettings:
        """Return the settings of a board; a name in its link has priority over its identity."""
        named = self.settings_named(node_name) if node_name is not None else None
        return named if named is not None else self.settings_matching(identity)

    def unchosen(self, link_names: Collection[str | None]) -> list[str]:
        """Return the devices without match keys that none of the links names."""
        chosen = {name.strip("~/") for name in link_names if name is not None}
        return [
            device.name
            for device in self.devices
            if device.match is None and device.name is not None and device.name.strip("~/") not in chosen
        ]

    def settings_named(self, node_name: str) -> DeviceSettings | None:
        """Return the settings of the device with this name, None if there is none."""
        wanted = node_name.strip("~/")
        for device in self.devices:
            if device.name is not None and device.name.strip("~/") == wanted:
                return device
        return None


def fits(match: DeviceMatch, identity: BoardIdentity) -> bool:
    """Return whether a board matches all given keys."""
    pairs = (
        (match.serial_number, identity.serial_number),
        (match.usb_id, identity.usb_id),
        (match.usb_location, identity.usb_location),
        (match.address, identity.address),
        (match.psk, identity.psk),
        (match.certificate, identity.certificate),
    )
    if any(wanted is not None and wanted != found for wanted, found in pairs):
        return False
    return match.port is None or (identity.port is not None and fits_port(identity.port, match.port))

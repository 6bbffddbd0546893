"""A rosserial device in Python."""

from rostether.device.device import Device

__all__ = ["Device"]

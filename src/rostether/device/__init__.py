"""A Python program that is itself a rosserial device."""

from rostether.device.device import Device

__all__ = ["Device"]

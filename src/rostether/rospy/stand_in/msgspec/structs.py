"""The functions of `msgspec.structs` for classes that are dataclasses here."""

from dataclasses import asdict, replace

__all__ = ["asdict", "replace"]

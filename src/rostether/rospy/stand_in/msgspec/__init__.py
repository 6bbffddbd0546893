"""The part of msgspec that our rospy needs, for other Python versions than the one it is compiled for."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

__all__ = ["Struct", "field"]


class Struct:
    """The base of value classes, which become dataclasses; options that only save memory have no effect."""

    __struct_fields__: tuple[str, ...] = ()

    def __init_subclass__(
        cls, *, frozen: bool = False, eq: bool = True, kw_only: bool = False, **_others: Any
    ) -> None:
        super().__init_subclass__()
        made = dataclass(frozen=frozen, eq=eq, kw_only=kw_only)(cls)
        cls.__struct_fields__ = tuple(each.name for each in fields(made))  # type: ignore[arg-type]

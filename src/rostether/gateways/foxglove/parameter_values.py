"""Parameters in the protocol: a name, a JSON value, and a type if JSON does not determine it.

`byte_array` is base64, `float64` and `float64_array` are numbers without a decimal point in JSON. JSON has no
NaN and no infinity: they are sent as strings; a set request converts these strings back if the parameter is a
float.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from typing import Any

from rostether.errors import ConfigError
from rostether.gateways.foxglove.client_messages import GivenParameter
from rostether.graph.ports import ParamValue
from rostether.serde.plain_form import clean_text

# The limit of nested mappings and lists: deeper than real ones, and far below Python's recursion limit.
MAX_DEPTH = 64

_SPECIAL = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}
_FLOAT, _FLOATS, _BYTES = "float64", "float64_array", "byte_array"


def describe(name: str, value: ParamValue) -> dict[str, Any]:
    """Return a parameter for clients; an unset one has no value."""
    if value is None:
        return {"name": name}
    described: dict[str, Any] = {"name": name, "value": _plain(value)}
    if isinstance(value, bytes):
        described["type"] = _BYTES
    elif isinstance(value, float) and math.isfinite(value):
        described["type"] = _FLOAT
    elif (
        isinstance(value, list)
        and value
        and all(isinstance(each, float) and math.isfinite(each) for each in value)
    ):
        described["type"] = _FLOATS
    return described


def given_value(given: GivenParameter, before: ParamValue) -> ParamValue:
    """Return the value to set; a whole number for a float parameter becomes a float. Raises ConfigError."""
    value = given.value
    if given.type == _FLOAT or (given.type is None and isinstance(before, float)):
        return _float(given.name, value)
    if given.type == _FLOATS or (given.type is None and _is_float_list(before) and isinstance(value, list)):
        if not isinstance(value, list):
            raise ConfigError(f"parameter {given.name} must be a list of numbers")
        return [_float(given.name, each) for each in value]
    return _native(given.name, value)


def _float(name: str, value: Any) -> float:
    if isinstance(value, str) and value in _SPECIAL:
        return _SPECIAL[value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"parameter {name} must be a number, not {str(value)[:40]!r}")
    try:
        return float(value)
    except OverflowError:
        raise ConfigError(f"parameter {name} is too large for a float") from None


def _is_float_list(value: ParamValue) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(each, float) for each in value)


def _native(name: str, value: Any, depth: int = 0) -> ParamValue:
    if depth > MAX_DEPTH:
        raise ConfigError(f"parameter {name} is nested more than {MAX_DEPTH} levels deep")
    if isinstance(value, dict):
        return {str(key): _native(name, each, depth + 1) for key, each in value.items()}
    if isinstance(value, list):
        return [_native(name, each, depth + 1) for each in value]
    if isinstance(value, bool | int | float | str | bytes):
        return value
    raise ConfigError(f"parameter {name} cannot hold null inside of a value")


def _plain(value: ParamValue) -> Any:
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    if isinstance(value, str):
        return clean_text(value)
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, Mapping):
        return {clean_text(str(key)): _plain(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return value

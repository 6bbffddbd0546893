from __future__ import annotations

import json
import math
from typing import Any

import pytest

from rostether.errors import ConfigError
from rostether.gateways.foxglove.client_messages import GivenParameter
from rostether.gateways.foxglove.parameters import describe, given_value
from rostether.graph.ports import ParamValue


@pytest.mark.parametrize(
    ("value", "described"),
    [
        (1, {"value": 1}),
        (True, {"value": True}),
        (1.0, {"value": 1.0, "type": "float64"}),
        ([1.0, 2.5], {"value": [1.0, 2.5], "type": "float64_array"}),
        ([], {"value": []}),
        ([1, 2.5], {"value": [1, 2.5]}),
        ("text", {"value": "text"}),
        ("\udcff", {"value": "\ufffd"}),
        (b"\0\xff", {"value": "AP8=", "type": "byte_array"}),
        (math.nan, {"value": "NaN"}),
        ([math.inf], {"value": ["Infinity"]}),
        ({"a": {"b": [1]}}, {"value": {"a": {"b": [1]}}}),
        (None, {}),
    ],
)
def test_values_are_described(value: ParamValue, described: dict[str, Any]) -> None:
    assert describe("/p", value) == {"name": "/p", **described}


@pytest.mark.parametrize(
    ("value", "kind", "before", "wanted"),
    [
        (3, None, None, 3),
        (3, None, 1.5, 3.0),
        (3, "float64", None, 3.0),
        ("NaN", None, -math.inf, math.nan),
        ([1, 2], "float64_array", None, [1.0, 2.0]),
        ([1, 2], None, [0.5], [1.0, 2.0]),
        ("YWI=", "byte_array", None, b"ab"),
        ({"a": [1]}, None, None, {"a": [1]}),
        (True, None, None, True),
    ],
)
def test_given_values_get_the_type_that_is_meant(
    value: Any, kind: str | None, before: ParamValue, wanted: ParamValue
) -> None:
    found = given_value(GivenParameter("/p", value, kind), before)
    assert type(found) is type(wanted)
    assert repr(found) == repr(wanted)


@pytest.mark.parametrize(
    ("value", "kind", "before"),
    [
        (True, None, 1.0),
        ("x", "float64", None),
        (10**400, "float64", None),
        (1, "float64_array", None),
        (1, "byte_array", None),
        ("YW", "byte_array", None),
        ([None], None, None),
        (json.loads("[" * 400 + "]" * 400), None, None),
    ],
)
def test_what_cannot_be_a_value_is_named(value: Any, kind: str | None, before: ParamValue) -> None:
    with pytest.raises(ConfigError, match="/p"):
        given_value(GivenParameter("/p", value, kind), before)

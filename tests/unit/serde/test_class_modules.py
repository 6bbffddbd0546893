from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest

from rostether.serde.class_modules import add_class_modules, bundled_store


@pytest.fixture
def parent() -> Iterator[dict[str, object]]:
    parent: dict[str, object] = {"__name__": "made"}
    add_class_modules(parent, lambda name: bundled_store().codec(name).message_class, "message")
    yield parent
    for name in [name for name in sys.modules if name.startswith("made.")]:
        del sys.modules[name]


def test_a_package_is_a_module_with_its_classes(parent: dict[str, object]) -> None:
    assert sys.modules["made.std_msgs"] is parent["std_msgs"]
    assert getattr(parent["std_msgs"], "Bool")._type == "std_msgs/Bool"  # noqa: B009 - made when asked for


@pytest.mark.parametrize("name", ["Nothing", "_private"])
def test_other_attributes_do_not_exist(parent: dict[str, object], name: str) -> None:
    with pytest.raises(AttributeError, match=f"module 'made.std_msgs' has no message '{name}'"):
        getattr(parent["std_msgs"], name)

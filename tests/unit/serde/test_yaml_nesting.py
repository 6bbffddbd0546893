from __future__ import annotations

import pytest
import yaml

from rostether.errors import SerializationError
from rostether.serde.yaml_form import load_arguments
from rostether.serde.yaml_nesting import MAX_NESTING, refuse_deep_nesting

DEEP = [opening * 100_000 for opening in ("[", "{a: ", "- ", "? ")]


@pytest.mark.parametrize("text", DEEP)
def test_what_would_crash_libyaml_is_refused(text: str) -> None:
    with pytest.raises(yaml.YAMLError):
        refuse_deep_nesting(text)
    with pytest.raises(SerializationError, match="not YAML"):
        load_arguments(text)


def test_long_and_flat_is_taken() -> None:
    text = f"[{'[1, 2], ' * 10_000}]"
    refuse_deep_nesting(text)
    assert len(load_arguments(text)[0]) == 10_000


def test_the_limit() -> None:
    padding = "# " + "x" * 10_000 + "\n"
    refuse_deep_nesting(padding + "[" * MAX_NESTING + "]" * MAX_NESTING)
    with pytest.raises(yaml.YAMLError, match="nested deeper than"):
        refuse_deep_nesting(padding + "[" * (MAX_NESTING + 1) + "]" * (MAX_NESTING + 1))

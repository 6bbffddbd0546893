from __future__ import annotations

import pytest

from rostether.launch.parameter_upload import outermost


@pytest.mark.parametrize(
    ("namespaces", "kept"),
    [
        ([], []),
        (["/a/"], ["/a/"]),
        (["/a/", "/a/"], ["/a/"]),
        (["/a/b/", "/a/", "/ab/"], ["/a/", "/ab/"]),
        (["/a/", "/", "/b/c/"], ["/"]),
    ],
)
def test_namespaces_inside_of_others_are_cleared_with_them(namespaces: list[str], kept: list[str]) -> None:
    assert outermost(namespaces) == kept

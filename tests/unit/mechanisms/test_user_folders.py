from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rostether.mechanisms.user_folders import FolderKind, user_folder


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has folders of its own")
def test_folders_of_the_xdg_specification(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/me")
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", "/x")
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    found = [user_folder(kind) for kind in (FolderKind.DATA, FolderKind.CONFIG, FolderKind.STATE)]
    assert found == [
        Path("/home/me/.local/share/rostether"),
        Path("/x/rostether"),
        Path("/home/me/.local/state/rostether"),
    ]


def test_folders_of_other_systems(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/Users/me")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(sys, "platform", "darwin")
    assert user_folder(FolderKind.CACHE) == Path("/Users/me/Library/Caches/rostether")
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", "/local")
    assert user_folder(FolderKind.CACHE) == Path("/local/rostether")

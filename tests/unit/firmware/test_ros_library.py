from __future__ import annotations

from pathlib import Path

import pytest

from rostether.firmware import ros_library
from rostether.firmware.cache import BuildCache
from rostether.firmware.ros_library import RosLibrary


def test_the_signature_changes_with_a_bundled_definition(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    definition = tmp_path / "msgdef" / "share" / "std_msgs" / "msg" / "Bool.msg"
    definition.parent.mkdir(parents=True)
    definition.write_text("bool data\n")
    monkeypatch.setattr(ros_library, "_PACKAGE", tmp_path)
    library = RosLibrary(BuildCache(tmp_path / "cache"), ())
    signature = library.signature()
    assert library.signature() == signature
    definition.write_text("bool data  # changed\n")
    assert library.signature() != signature

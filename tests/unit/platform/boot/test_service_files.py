from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError
from rostether.platform.boot.service_files import Installation, unit_text


def test_a_path_cannot_add_a_setting_to_the_unit() -> None:
    odd = Installation(("/opt/a b%h$X\\/rostether",), Path("/etc/robot.toml"), is_system=True)
    assert 'ExecStart="/opt/a b%%h$$X\\\\/rostether" up /etc/robot.toml' in unit_text(odd)
    hostile = Installation(("/usr/bin/rostether",), Path("/tmp/a\nExecStartPre=x"), is_system=True)
    with pytest.raises(ConfigError, match="cannot be in a systemd unit"):
        unit_text(hostile)

from __future__ import annotations

import subprocess
import sys

import pytest


@pytest.mark.usefixtures("cold_start")
@pytest.mark.parametrize("package", ["zenoh", "xxhash"])
def test_a_missing_package_is_an_error_with_the_command_to_install_it(package: str) -> None:
    program = (
        f"import sys; sys.modules[{package!r}] = None\n"
        "from rostether.errors import ConfigError\n"
        "from rostether.ros2.session import zenoh_sessions\n"
        "try:\n    zenoh_sessions()\nexcept ConfigError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "install 'rostether[zenoh]'" in done.stdout

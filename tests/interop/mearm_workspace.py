"""The example examples/mearm as catkin would build it: its packages, and modules made by Debian's genpy."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from interop.ros1_peers import DEBIAN_PYTHON, Ros1Peers

EXAMPLE = Path(__file__).parents[2] / "examples" / "mearm"
PACKAGE = EXAMPLE / "mearm_model"
_GENERATORS = {"msg": "/usr/lib/genpy/genmsg_py.py", "srv": "/usr/lib/genpy/gensrv_py.py"}
_DEBIAN_PATH = "/usr/sbin:/usr/bin:/sbin:/bin"


def build_for_debian(folder: Path) -> Path:
    """Copy the packages to a folder; return what to put on PYTHONPATH, made by genpy of the definitions."""
    shutil.copytree(EXAMPLE, folder / "src")
    modules = folder / "lib" / "python"
    for kind, generator in _GENERATORS.items():
        output = modules / "mearm_model" / kind
        definitions = sorted(map(str, (PACKAGE / kind).glob(f"*.{kind}")))
        for what in (definitions, ["--initpy"]):
            subprocess.run(
                [DEBIAN_PYTHON, generator, "-p", "mearm_model", "-o", str(output), *what],
                env={"PATH": _DEBIAN_PATH},
                check=True,
                capture_output=True,
            )
    (modules / "mearm_model" / "__init__.py").touch()
    return modules


def show_packages(peers: Ros1Peers, folder: Path) -> None:
    """Let Debian's programs find the packages of a folder and their modules."""
    modules = build_for_debian(folder)
    peers.environment["ROS_PACKAGE_PATH"] = os.pathsep.join([str(folder / "src"), "/usr/share"])
    peers.environment["PYTHONPATH"] = str(modules)

from __future__ import annotations

from pathlib import Path

import pytest

from firmware.platforms.programs import NODE, compile_for_cortex_m, compile_program
from rostether.codegen.arduino_library import write_library
from rostether.msgdef.registry import Registry


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The client library with the messages that the tests' programs use."""
    packages = ["std_msgs", "std_srvs", "tf", "rosserial_arduino"]
    return write_library(tmp_path_factory.mktemp("library"), Registry(), packages=packages).path


@pytest.fixture(scope="session")
def control_library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The client library with the messages that a robot of a fleet uses."""
    return write_library(tmp_path_factory.mktemp("library"), Registry(), packages=["arduino_control"]).path


@pytest.fixture(scope="session")
def linux_program(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The node for Linux, with checks for undefined behavior and memory leaks."""
    output = tmp_path_factory.mktemp("linux") / "node"
    sanitize = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    return compile_program(["g++", "-O1", *sanitize], [NODE / "host.cpp"], library, output)


@pytest.fixture(scope="session")
def cortex_m_program(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The node for a Stellaris, with platform/tivac.h."""
    return compile_for_cortex_m(
        NODE / "embedded.cpp", library, tmp_path_factory.mktemp("cortexm") / "node.elf"
    )


@pytest.fixture(scope="session")
def windows_program(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The node for Windows."""
    output = tmp_path_factory.mktemp("windows") / "node.exe"
    command = ["x86_64-w64-mingw32-g++", "-O2", "-static"]
    return compile_program(command, [NODE / "host.cpp"], library, output, "-lws2_32")

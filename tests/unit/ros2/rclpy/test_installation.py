"""The errors if rclpy or a package of types is missing."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rostether.errors import ConfigError, UnknownTypeError
from rostether.ros2.rclpy.installation import interface_class, load_rclpy


@pytest.fixture(autouse=True)
def _forget() -> None:
    for function in (load_rclpy, interface_class):
        function.cache_clear()


def test_the_error_about_a_missing_rclpy_has_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "rosidl_generator_py", None)
    monkeypatch.setitem(sys.modules, "rclpy.context", None)
    with pytest.raises(ConfigError, match=r"pip install 'rostether\[rclpy\]'; or source") as caught:
        load_rclpy()
    assert "\n" not in str(caught.value)


def test_a_middleware_that_is_not_installed_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for prefix, name in (
        ("python", "rmw_fastrtps_cpp"),
        ("ros", "rmw_zenoh_cpp"),
        ("ros", "rmw_implementation"),
    ):
        file = tmp_path / prefix / "share/ament_index/resource_index/rmw_typesupport" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "python"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "ros"))
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")
    with pytest.raises(
        ConfigError, match=r"rmw_cyclonedds_cpp is not installed .* rmw_fastrtps_cpp or rmw_zenoh_cpp"
    ):
        load_rclpy()
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")
    monkeypatch.setitem(sys.modules, "rosidl_generator_py", None)
    with pytest.raises(ConfigError, match="rclpy cannot be used"):
        load_rclpy()


@pytest.mark.parametrize("name", ["no_pkg/msg/A", "no_pkg/srv/A"])
def test_a_package_that_is_missing_is_named(name: str) -> None:
    with pytest.raises(UnknownTypeError, match="package no_pkg is not installed"):
        interface_class(name)


def test_a_type_that_is_missing_in_its_package_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "thin_msgs" / "msg"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("class Thin: pass\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert interface_class("thin_msgs/msg/Thin").__name__ == "Thin"
    with pytest.raises(UnknownTypeError, match="installed package thin_msgs does not contain it"):
        interface_class("thin_msgs/msg/Thick")


def test_a_package_that_cannot_be_imported_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "broken_msgs" / "msg"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("raise ImportError('libbroken.so:\\n cannot open')\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(UnknownTypeError, match=r"cannot be imported \(libbroken.so: cannot open\)"):
        interface_class("broken_msgs/msg/Broken")

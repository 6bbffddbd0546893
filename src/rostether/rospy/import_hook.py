"""Makes definitions importable, such as `mearm_model.msg`, and the Python modules in `src` of a package.

The hook is installed only if there is no real rospy. Then a `std_msgs.msg` that Python finds belongs to ROS
2, and programs for rospy cannot use it. So the definitions have priority.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Callable, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

from rostether.errors import RostetherError

_KINDS = ("msg", "srv")

MODULES_FOLDER = Path(__file__).with_name("modules")

_GENPY_MESSAGE = "client.message client.message_arguments client.message_types client.stamps"

# Modules of ROS, each with the modules of `rostether.rospy` that implement it. If several define a name, the
# last one counts. The folder `modules` contains the other modules of ROS.
_IMPLEMENTATIONS = {
    "actionlib.action_client": "actionlib.action_client actionlib.client_goal actionlib.comm_states",
    "actionlib.action_server": "actionlib.action_server",
    "actionlib.exceptions": "actionlib.action_types",
    "actionlib.goal_id_generator": "actionlib.goal_ids",
    "actionlib.server_goal_handle": "actionlib.server_goal",
    "actionlib.simple_action_client": "actionlib.simple_action_client",
    "actionlib.simple_action_server": "actionlib.simple_action_server",
    "genpy.dynamic": "client.message_types",
    "genpy.message": _GENPY_MESSAGE,
    "genpy.rostime": "client.stamps",
    "message_filters": "client.message_filters",
    "rosbag.bag": "bag.bag bag.facts bag.types",
    "rosgraph.names": "tools.graph_names",
    "rosgraph.network": "tools.graph_network",
    "roslib.message": _GENPY_MESSAGE,
    "roslib.names": "tools.graph_names",
    "roslib.packages": "tools.ros_packages",
    "rosmsg": "client.definition_texts",
    "rosnode": "tools.node_lookup",
    "rospkg.common": "tools.ros_packages",
    "rospkg.environment": "tools.ros_packages",
    "rospkg.rospack": "tools.ros_packages",
    "rospy.client": "client.client client.logs client.parameters client.shutdown",
    "rospy.core": "client.exceptions client.logs client.names client.node client.services client.shutdown",
    "rospy.exceptions": "client.exceptions",
    "rospy.msg": "client.message client.publisher",
    "rospy.msproxy": "client.parameters",
    "rospy.names": "tools.graph_names client.names",
    "rospy.numpy_msg": "client.numpy_messages",
    "rospy.rostime": "client.ros_time",
    "rospy.service": "client.exceptions",
    "rospy.timer": "client.ros_time",
    "rospy.topics": "client.publisher client.subscriber",
    "rosserial_python": "client.serial_client",
    "rosservice": "tools.service_lookup",
    "tf.broadcaster": "tf.broadcaster",
    "tf.listener": "tf.transformer",
    "tf.transformations": "tf.transformations",
    "tf2_ros.buffer": "tf.buffer",
    "tf2_ros.buffer_client": "tf.buffer_client",
    "tf2_ros.buffer_interface": "tf.buffer_interface",
    "tf2_ros.static_transform_broadcaster": "tf.listener_and_broadcasters",
    "tf2_ros.transform_broadcaster": "tf.listener_and_broadcasters",
    "tf2_ros.transform_listener": "tf.listener_and_broadcasters",
}

# Modules that scripts for rospy often import, and that only a real ROS has.
_ONLY_IN_ROS = frozenset({"cv_bridge", "dynamic_reconfigure", "roslaunch"})

# Modules of ROS 1 that the ROS 2 packages of the same names lack; Python may find these packages first.
_BESIDE_MESSAGES = frozenset({"sensor_msgs.point_cloud2"})


def install() -> None:
    """Make definitions and packages importable in this process. Idempotent."""
    if not any(isinstance(finder, DefinitionFinder) for finder in sys.meta_path):
        # This finder comes before those of Python, which would find an empty package in a folder `msg` of
        # definitions, and ROS 2's messages instead of these.
        sys.meta_path.insert(0, DefinitionFinder())
        sys.meta_path.append(PackageFinder())


def import_submodules(package: str) -> None:
    """Import the modules of a ROS package that are implemented here.

    Programs use them after an import of only the package.
    """
    for name in _IMPLEMENTATIONS:
        if name.startswith(f"{package}."):
            importlib.import_module(name)


class DefinitionFinder(MetaPathFinder):
    """Finds `package.msg`, `package.srv`, and modules such as `package.msg._Name`, as in genpy."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return a spec for a module of known definitions; None for other modules."""
        if fullname in _BESIDE_MESSAGES:
            return importlib.util.spec_from_file_location(
                fullname, MODULES_FOLDER.joinpath(*fullname.split(".")).with_suffix(".py")
            )
        package, _, rest = fullname.partition(".")
        kind, _, single = rest.partition(".")
        if kind not in _KINDS or (single and not single.startswith("_")):
            return None
        from rostether.rospy.client.message_types import all_types

        types = all_types()
        names = (types.registry.messages if kind == "msg" else types.registry.services)(package)
        if not names:
            return None
        loader = _DefinitionLoader(package, kind, [name.partition("/")[2] for name in names])
        return ModuleSpec(fullname, loader, is_package=not single)


class PackageFinder(MetaPathFinder):
    """Finds the rest: modules of ROS, Python modules in a package's `src`, and packages of definitions."""

    def __init__(self) -> None:
        self._folders: dict[str, Path] | None = None

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return a spec for a module or package that Python itself does not find; None if there is none.

        Raises ModuleNotFoundError with the next step for a module that seems to belong to ROS.
        """
        if names := _IMPLEMENTATIONS.get(fullname):
            return ModuleSpec(fullname, _FacadeLoader(names.split()))
        if "." in fullname or fullname.startswith("_"):
            return None
        from rostether.rospy.client.message_types import all_types

        if self._folders is None:
            self._folders = importable_packages()
        own = self._folders.get(fullname)
        for folder in (own, *self._folders.values()):
            if folder is not None and (spec := _python_of(folder, fullname)):
                return spec
        if fullname in all_types().packages:
            return ModuleSpec(fullname, _EmptyLoader(), is_package=True)
        if fullname in _ONLY_IN_ROS:
            raise ModuleNotFoundError(
                f"No module named {fullname!r}: rostether does not include it; install ROS to use it",
                name=fullname,
            )
        if fullname.endswith("_msgs"):
            raise ModuleNotFoundError(
                f"No module named {fullname!r}: put the package with its .msg files into your workspace, or "
                "into a folder of ROS_PACKAGE_PATH",
                name=fullname,
            )
        return None


def importable_packages() -> dict[str, Path]:
    """Map the names of the packages that this program can use to their folders."""
    from rostether.packages.search_path import find_packages
    from rostether.rospy.environment import package_search_path

    return find_packages(package_search_path(os.environ))


class _EmptyLoader(Loader):
    def exec_module(self, module: ModuleType) -> None:
        pass


class _FacadeLoader(Loader):
    """Fills a module with the names of the modules that implement it."""

    def __init__(self, module_names: list[str]) -> None:
        self._module_names = module_names

    def exec_module(self, module: ModuleType) -> None:
        for module_name in self._module_names:
            names = vars(importlib.import_module(f"{__package__}.{module_name}"))
            vars(module).update((name, value) for name, value in names.items() if not name.startswith("__"))


class _DefinitionLoader(Loader):
    def __init__(self, package: str, kind: str, names: list[str]) -> None:
        self._package = package
        self._kind = kind
        self._names = names

    def exec_module(self, module: ModuleType) -> None:
        public = [*self._names]
        if self._kind == "srv":
            public += [f"{name}{suffix}" for name in self._names for suffix in ("Request", "Response")]
        space: dict[str, Any] = vars(module)
        space["__all__"] = sorted(public)
        space["__dir__"] = lambda: sorted({*space, *public})
        space["__getattr__"] = self._attribute(module, frozenset(public))

    def _attribute(self, module: ModuleType, public: frozenset[str]) -> Callable[[str], Any]:
        from rostether.rospy.client.message_types import all_types

        def attribute(name: str) -> Any:
            if name not in public:
                raise AttributeError(
                    f"module {module.__name__!r} has no {name!r}: package {self._package} has no file "
                    f"{name}.{self._kind}"
                )
            types = all_types()
            make: Callable[[str], Any] = (
                types.service_class if name in self._names and self._kind == "srv" else types.message_class
            )
            try:
                made = make(f"{self._package}/{name}")
            except RostetherError as error:
                raise ImportError(f"{error}", name=module.__name__) from None
            setattr(module, name, made)
            return made

        return attribute


def _python_of(folder: Path, name: str) -> ModuleSpec | None:
    """Return the spec of a Python package or module in a ROS package's `src`; None if there is none."""
    init = folder / "src" / name / "__init__.py"
    if init.is_file():
        return importlib.util.spec_from_file_location(
            name, init, submodule_search_locations=[str(init.parent)]
        )
    module = folder / "src" / f"{name}.py"
    if module.is_file() and (folder / "setup.py").is_file():
        return importlib.util.spec_from_file_location(name, module)
    return None

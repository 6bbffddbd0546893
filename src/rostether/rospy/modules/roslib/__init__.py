"""roslib: the functions from before catkin, and those that convert type names to classes."""

from rostether.rospy.import_hook import import_submodules as _import_submodules

_import_submodules(__name__)


def load_manifest(package_name: str, bootstrap_version: str = "0.7") -> None:
    """Do nothing: packages are importable without their manifest."""


def is_interactive() -> bool:
    """Return False: there is no interactive session."""
    return False

"""Makes our rospy importable: Python runs this at its start if `run` or `launch` has put it on PYTHONPATH.

It appends the folder with our `rospy` to the path, unless a real rospy is installed. It also runs the
sitecustomize.py of the system or the user, because Python itself runs only the first one.
"""

import importlib.machinery
import importlib.util
import os
import sys


def _run_other_sitecustomize(here: str) -> None:
    others = [entry for entry in sys.path if os.path.abspath(entry) != here]  # noqa: PTH100
    spec = importlib.machinery.PathFinder.find_spec("sitecustomize", others)
    if spec is not None and spec.loader is not None:
        spec.loader.exec_module(importlib.util.module_from_spec(spec))


def _add_rospy(here: str) -> None:
    if sys.version_info < (3, 11) or importlib.util.find_spec("rospy") is not None:
        return
    facade = os.path.dirname(here)  # noqa: PTH120
    for folder in os.environ.get("ROSTETHER_IMPORT_PATH", "").split(os.pathsep):
        # On another Python, these folders are not in the path. Its own packages have priority.
        if folder and folder not in sys.path:
            sys.path.append(folder)
    sys.path.append(os.path.join(facade, "modules"))  # noqa: PTH118
    # Imported before `install`, because our finder would search for the optional modules that msgspec tries.
    try:
        import msgspec  # noqa: F401
    except ImportError:
        # msgspec is compiled for the version of Python in which rostether is installed.
        sys.path.insert(0, os.path.join(facade, "stand_in"))  # noqa: PTH118
    from rostether.rospy.import_hook import install

    install()


_here = os.path.dirname(os.path.abspath(__file__))  # noqa: PTH100, PTH120
_run_other_sitecustomize(_here)
_add_rospy(_here)

"""Python runs this at start if `run` or `launch` has put its folder on PYTHONPATH.

It appends the folder with our `rospy` to the path, unless a real rospy is installed. A sitecustomize.py of
the system or of the user also runs.
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
        # The script runs on another Python: its own packages come first, then rostether and its dependencies.
        if folder and folder not in sys.path:
            sys.path.append(folder)
    sys.path.append(os.path.join(facade, "modules"))  # noqa: PTH118
    # Imported before our finder is added, which would search for the optional modules that msgspec tries.
    try:
        import msgspec  # noqa: F401
    except ImportError:
        # It is compiled for the Python that rostether is installed in, and this is another version.
        sys.path.insert(0, os.path.join(facade, "stand_in"))  # noqa: PTH118
    from rostether.rospy.import_hook import install

    install()


_here = os.path.dirname(os.path.abspath(__file__))  # noqa: PTH100, PTH120
_run_other_sitecustomize(_here)
_add_rospy(_here)

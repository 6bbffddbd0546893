"""The launch files of tests/vectors/launch, and the results of roslaunch for them.

`expected.json` has the recorded results of Debian's roslaunch. tests/interop compares them with roslaunch.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from rostether.launch.command_line import node_environment
from rostether.launch.loading import load_launch
from rostether.launch.plan import DeleteParameters, DumpParameters, LaunchPlan
from rostether.launch.substitution import LaunchContext
from rostether.names.remap import ASSIGNMENT

FOLDER = Path(__file__).parents[2] / "vectors" / "launch"
ROBOT = FOLDER / "corpus_robot"
RIGHT = sorted((ROBOT / "launch").glob("*.launch"))
WRONG = sorted((ROBOT / "wrong").glob("*.launch"))
EXPECTED = FOLDER / "expected.json"
ENVIRON = {"CORPUS_HOME": "/home/corpus"}
MASTER_URI = "http://localhost:11311"

_GIVEN = re.compile(r"<!-- given: (.*) -->")
_ANONYMOUS = re.compile(r"_\w+_\d+_\d{6,}")
_FOLDER_MARK = "@CORPUS@"


def given_words(file: Path) -> list[str]:
    """Return the arguments in the first comment of a file."""
    found = _GIVEN.match(file.read_bytes().decode("latin-1"))
    return found[1].split() if found else []


def load(file: Path) -> LaunchPlan:
    """Read one file of the corpus."""
    arguments = dict(word.split(ASSIGNMENT, 1) for word in given_words(file))
    context = LaunchContext({**ENVIRON, "PATH": "/usr/bin:/bin"}, {"corpus_robot": ROBOT})
    return load_launch([file], arguments, context)


def expected() -> dict[str, Any]:
    """Return the results of roslaunch by file name."""
    results: dict[str, Any] = json.loads(EXPECTED.read_text())
    return results


def neutral(value: Any) -> Any:
    """Return a result as JSON values, without the folders of this machine and without random names."""
    text = json.dumps(value).replace(str(ROBOT), _FOLDER_MARK)
    return json.loads(_ANONYMOUS.sub("_ANONYMOUS", text))


def exact(value: Any) -> str:
    """Return a result as text, because in Python 1 equals 1.0 and True."""
    return json.dumps(value, indent=1, sort_keys=True, ensure_ascii=False)


def described(plan: LaunchPlan) -> Any:
    """Return a plan in the form of the recorded results."""
    return neutral(
        {
            "parameters": {
                key: {"binary": value.hex()} if isinstance(value, bytes) else value
                for key, value in plan.parameters.items()
            },
            "nodes": [
                {
                    "package": node.package,
                    "type": node.type,
                    "name": node.name,
                    "namespace": node.namespace.rstrip("/") + "/",
                    "args": node.args,
                    "remaps": [list(each) for each in node.remaps],
                    "environment": node_environment(node, {"ROS_NAMESPACE": "/callers"}, MASTER_URI),
                    "respawn": node.respawn,
                    "respawn_delay_s": node.respawn_delay_s,
                    "required": node.required,
                    "output": node.output.value,
                    "cwd": node.working_folder.value,
                    "launch_prefix": node.launch_prefix,
                }
                for node in plan.nodes
            ],
            "cleared": list(plan.cleared),
            "before": [_before(step) for step in plan.before],
            "arguments": {
                each.name: [each.default, each.doc or None]
                for each in plan.arguments.values()
                if not each.is_fixed
            },
        }
    )


def _before(step: DumpParameters | DeleteParameters) -> list[str]:
    if isinstance(step, DumpParameters):
        return ["dump", step.file, step.namespace]
    return ["delete", step.name]

"""The content of launch files: nodes, parameters to set, and parameters to dump, delete or clear before."""

from __future__ import annotations

import shlex
from enum import Enum

from msgspec import Struct, field

from rostether.graph.ports import ParamValue
from rostether.names.graph_name import canonical, join


class Output(Enum):
    """The destination of a node's standard output."""

    LOG = "log"
    SCREEN = "screen"


class WorkingFolder(Enum):
    """The folder in which a node starts."""

    ROS_HOME = "ROS_HOME"
    NODE = "node"


class LaunchNode(Struct, frozen=True):
    """One process to start.

    `name` has no namespace. `namespace` is global, without a trailing slash except for the root. `remaps` are
    pairs (from, to) as written. Later pairs of `environment` override earlier ones.
    """

    package: str
    type: str
    name: str
    namespace: str = "/"
    args: str = ""
    remaps: tuple[tuple[str, str], ...] = ()
    environment: tuple[tuple[str, str], ...] = ()
    respawn: bool = False
    respawn_delay_s: float = 0.0
    required: bool = False
    output: Output = Output.LOG
    working_folder: WorkingFolder = WorkingFolder.ROS_HOME
    launch_prefix: str = ""
    file: str = ""
    line: int = 0

    @property
    def full_name(self) -> str:
        """The node's name in the graph."""
        return canonical(join(self.namespace, self.name))

    @property
    def arguments(self) -> list[str]:
        """The command-line arguments of the node: its own arguments, its remaps and its name."""
        remaps = [f"{source}:={target}" for source, target in self.remaps]
        return [*shlex.split(self.args), *remaps, f"__name:={self.name}"]


class DumpParameters(Struct, frozen=True):
    """Write a namespace of the parameter server, as it is before the launch, to a YAML file."""

    namespace: str
    file: str


class DeleteParameters(Struct, frozen=True):
    """Delete a parameter or namespace before the launch."""

    name: str


class DeclaredArgument(Struct, frozen=True):
    """An <arg> of a launch file. Users must give a value if it has no default, but cannot if it is fixed."""

    name: str
    default: str | None = None
    doc: str = ""
    is_fixed: bool = False


class LaunchPlan(Struct):
    """The whole plan, in the order of execution: `before`, `cleared`, `parameters`, `nodes`.

    `cleared` are namespaces with a trailing slash. `arguments` are those of the given files, by name;
    `argument_names` also has those of included files. `files` are all files that were read, each once.
    `warnings` are lines for users.
    """

    nodes: list[LaunchNode] = field(default_factory=list)
    parameters: dict[str, ParamValue] = field(default_factory=dict)
    before: list[DumpParameters | DeleteParameters] = field(default_factory=list)
    cleared: list[str] = field(default_factory=list)
    arguments: dict[str, DeclaredArgument] = field(default_factory=dict)
    argument_names: set[str] = field(default_factory=set)
    files: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

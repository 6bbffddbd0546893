"""The scope at a position in a launch file: namespace, arguments, remaps, environment, private parameters.

A <group>, <node> or <include> gets a copy of the scope around it, so settings inside do not apply after it.
An included file sees only the arguments in its <include>.
"""

from __future__ import annotations

from msgspec import Struct, field

from rostether.errors import LaunchError
from rostether.graph.ports import ParamValue
from rostether.launch.plan import DeclaredArgument
from rostether.names.graph_name import (
    PRIVATE,
    SEPARATOR,
    as_namespace,
    canonical,
    is_legal_name,
    join,
)


class Scope(Struct):
    """The state at one position; `namespace` is global and ends with a slash."""

    file: str
    namespace: str = SEPARATOR
    arguments: dict[str, str] = field(default_factory=dict)
    declared: dict[str, DeclaredArgument] = field(default_factory=dict)
    anonymous_names: dict[str, str] = field(default_factory=dict)
    remaps: list[tuple[str, str]] = field(default_factory=list)
    environment: list[tuple[str, str]] = field(default_factory=list)
    private_params: dict[str, ParamValue] = field(default_factory=dict)
    passes_all_arguments: bool = False

    def child(self, namespace: str | None = None) -> Scope:
        """Return a copy for a scope inside this one. Raises LaunchError for a private namespace."""
        if namespace is not None and namespace.startswith(PRIVATE):
            raise LaunchError(f"ns={namespace!r} is private to a node; give a namespace like robot1 or /lab")
        return Scope(
            file=self.file,
            namespace=self.namespace if namespace is None else as_namespace(join(self.namespace, namespace)),
            arguments=dict(self.arguments),
            declared=dict(self.declared),
            anonymous_names=dict(self.anonymous_names),
            remaps=list(self.remaps),
            environment=list(self.environment),
            private_params=dict(self.private_params),
        )

    def included(self, file: str, inside: Scope, given: dict[str, str], *, pass_all: bool) -> Scope:
        """Return the scope of an included file; `inside` is the scope of the <include>'s children."""
        return Scope(
            file=file,
            namespace=inside.namespace,
            arguments=given,
            remaps=inside.remaps,
            environment=inside.environment,
            # As in roslaunch: if there are already private parameters, those of the included file also apply
            # to the nodes after the <include>.
            private_params=self.private_params or {},
            passes_all_arguments=pass_all,
        )

    def declare(self, argument: DeclaredArgument, value: str | None) -> None:
        """Declare an <arg>, which is fixed with a `value`.

        Raises LaunchError if it is declared twice, or if it is fixed and was given.
        """
        name = argument.name
        if name in self.declared and not self.passes_all_arguments:
            raise LaunchError(f"argument {name!r} is declared twice; rename or remove one")
        if value is not None:
            if name in self.arguments and not self.passes_all_arguments:
                raise LaunchError(
                    f"argument {name!r} has a fixed value and cannot be given; use default= instead of value="
                )
            self.arguments[name] = value
        elif argument.default is not None:
            self.arguments.setdefault(name, argument.default)
        self.declared[name] = argument

    def remap(self, source: str, target: str) -> None:
        """Add a remapping; replace an earlier one from the same name. Raises LaunchError."""
        pair = (canonical(source), canonical(target))
        for name in pair:
            if not name:
                raise LaunchError("<remap> has an empty from= or to=; both need a name")
            if not is_legal_name(name):
                raise LaunchError(f"<remap> cannot use {name!r}: it is not a ROS name; correct it")
        self.remaps = [each for each in self.remaps if each[0] != pair[0]] + [pair]

"""Finds ROS 2 messages and services by name: in the user's folders, in installed packages, or bundled."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from rostether.errors import UnknownTypeError
from rostether.msgdef.definition_files import (
    Kind,
    PackageFiles,
    existing_folders,
    find_definitions,
    read_definition,
)
from rostether.msgdef.ros2.action_parts import ActionParts, action_of_part, action_parts
from rostether.msgdef.ros2.definition_files import (
    BUNDLED_DISTRO,
    Definition,
    InstalledPackages,
    bundled_names,
    bundled_packages,
    declares_ros2,
    install_prefixes,
    named_distro,
    parse_file,
    python_prefixes,
    reads_as_ros2,
)
from rostether.msgdef.ros2.definition_text import message_text
from rostether.msgdef.ros2.parse import REQUEST_SUFFIX, RESPONSE_SUFFIX
from rostether.msgdef.ros2.spec import Ros2Action, Ros2Message, Ros2Service
from rostether.msgdef.ros2.to_ros1 import joined_services
from rostether.msgdef.ros2.unknown_type import explain_only_idl, explain_unknown, split_name
from rostether.packages.locate import package_path

# A workspace of many packages has a prefix for each; an error is one readable line.
_SHOWN_FOLDERS = 4


class Ros2Definitions:
    """Finds, parses and caches ROS 2 definitions; each is read on demand.

    `paths` are folders of packages or of plain definitions (--msg-path), where ROS 1 texts are ignored;
    `package_path` are folders of packages (ROS_PACKAGE_PATH); `prefixes` are install prefixes, as
    in AMENT_PREFIX_PATH. All override the bundled definitions of `distro`, in the order given: a
    package replaces the whole bundled one, a plain folder replaces single types. `last_prefixes` are
    searched last.
    """

    def __init__(
        self,
        paths: Iterable[Path | str] = (),
        *,
        package_path: Iterable[Path] = (),
        prefixes: Iterable[Path | str] = (),
        last_prefixes: Iterable[Path | str] = (),
        distro: str = BUNDLED_DISTRO,
        bundled: bool = True,
    ) -> None:
        self.distro = distro
        self._paths = [Path(path) for path in paths]
        self._package_path = list(package_path)
        self._installed = InstalledPackages(Path(prefix) for prefix in prefixes)
        self._installed_last = InstalledPackages(Path(prefix) for prefix in last_prefixes)
        self._bundled = bundled
        self._found: dict[str, PackageFiles] | None = None
        self._messages: dict[str, Ros2Message] = {}
        self._services: dict[str, Ros2Service] = {}
        self._actions: dict[str, ActionParts] = {}
        self._added: set[str] = set()
        # Whether a file in the user's folders is a ROS 2 text.
        self._is_ros2_file: dict[Path, bool] = {}

    @classmethod
    def from_environment(
        cls, msg_paths: Iterable[Path | str] = (), environ: Mapping[str, str] | None = None
    ) -> Ros2Definitions:
        """Return the definitions in --msg-path folders, on the paths of ROS 1 and ROS 2, and from pip.

        Raises ConfigError for a missing folder.
        """
        environ = os.environ if environ is None else environ
        distro = named_distro(environ) or BUNDLED_DISTRO
        # Packages from pip may be of another distribution: they only add types.
        return cls(
            existing_folders(msg_paths),
            package_path=package_path(environ),
            prefixes=install_prefixes(environ),
            last_prefixes=python_prefixes(),
            distro=distro,
        )

    @property
    def is_searched(self) -> bool:
        """Whether all types are found without a search of folders."""
        is_on_path = self._found is not None or not (self._paths or self._package_path)
        return is_on_path and self._installed.is_searched and self._installed_last.is_searched

    def search(self) -> None:
        """Search all folders now. It may take seconds."""
        self._on_path()
        self._installed.search()
        self._installed_last.search()

    @property
    def searched_folders(self) -> str:
        """The searched folders, as text for errors."""
        folders = [f"--msg-path {path}" for path in self._paths]
        folders += map(str, (*self._package_path, *self._installed.prefixes))
        if len(folders) > _SHOWN_FOLDERS:
            folders = [*folders[:_SHOWN_FOLDERS], f"{len(folders) - _SHOWN_FOLDERS} more folders"]
        if self._installed_last.prefixes:
            folders.append("the packages of this Python")
        if self._bundled:
            folders.append(f"the bundled definitions of {self.distro}")
        return ", ".join(folders)

    def add(self, messages: Iterable[Ros2Message]) -> None:
        """Add other definitions, a service as its request and response; known ones are unchanged."""
        for message in messages:
            if not self.has(message.full_name):
                self._messages[message.full_name] = message
                self._added.add(message.full_name)
        for service in joined_services(self._messages):
            # A type description also lists a service as a message, so its name may be known already.
            if service.full_name in self._added or not self.has(service.full_name):
                self._services[service.full_name] = service
                self._added.add(service.full_name)

    def message(self, name: str) -> Ros2Message:
        """Return a message by `package/msg/Name`, or a request or response by `package/srv/Name_Request`.

        Raises UnknownTypeError, or DefinitionError if its own text is broken.
        """
        found = self._messages.get(name)
        if found is None:
            found = self._messages[name] = self._load_message(name)
        return found

    def service(self, name: str) -> Ros2Service:
        """Return a service by `package/srv/Name`. Raises UnknownTypeError, DefinitionError."""
        found = self._services.get(name)
        if found is None:
            package, kind, short_name = split_name(name, Kind.SERVICE)
            if kind is Kind.ACTION:
                self.action(f"{package}/action/{action_of_part(short_name)}")
                if name in self._services:
                    return self._services[name]
            if kind is not Kind.SERVICE:
                raise UnknownTypeError(f"{name} is a message, not a service")
            loaded = self._load(Kind.SERVICE, package, short_name)
            assert isinstance(loaded, Ros2Service)
            found = self._services[name] = loaded
        return found

    def action(self, name: str) -> ActionParts:
        """Return an action by `package/action/Name`. Raises UnknownTypeError, DefinitionError."""
        found = self._actions.get(name)
        if found is None:
            package, _, short_name = split_name(name, Kind.ACTION)
            loaded = self._load(Kind.ACTION, package, short_name)
            assert isinstance(loaded, Ros2Action)
            found = self._actions[name] = action_parts(loaded)
            self._messages.update((each.full_name, each) for each in found.messages())
            self._services.update((each.full_name, each) for each in found.services)
        return found

    def text(self, name: str) -> str:
        """Return the original text of a message, by `package/msg/Name`.

        Raises the same errors as `message`.
        """
        text = self.file_text(name) if split_name(name)[1] is Kind.MESSAGE else None
        return message_text(self.message(name)) if text is None else text

    def file_text(self, name: str) -> str | None:
        """Return the text of the file that defines a message, service or action; None if there is no file.

        Raises DefinitionError.
        """
        package, kind, short_name = split_name(name)
        file = None if name in self._added else self._file(kind, package, short_name)
        return None if file is None else read_definition(file)

    def has(self, name: str) -> bool:
        """Return whether a message, service, request or response is known; reads only the user's texts."""
        if name in self._added:
            return True
        try:
            package, kind, short_name = split_name(name)
        except UnknownTypeError:
            return False
        if kind is Kind.ACTION:
            short_name = action_of_part(short_name)
        names = [short_name]
        if kind is Kind.SERVICE:
            names += [short_name.removesuffix(suffix) for suffix in (REQUEST_SUFFIX, RESPONSE_SUFFIX)]
        return any(self._file(kind, package, each) is not None for each in names)

    def packages(self) -> list[str]:
        """Return the names of all packages that have definitions, sorted."""
        names = {*self._installed.packages(), *self._installed_last.packages()}
        names.update(package for package in self._on_path() if any(self._own(package, kind) for kind in Kind))
        if self._bundled:
            names.update(bundled_packages())
        return sorted(names)

    def names(self, kind: Kind, package: str | None = None) -> list[str]:
        """Return the full names of all definitions of a kind, or of one package's, sorted.

        The messages of services and actions are not among the messages.
        """
        names: set[str] = set()
        for each in self.packages() if package is None else [package]:
            found = {name for name, file in self._own(each, kind).items() if self._is_ros2(file, kind, each)}
            found.update(self._installed.of(each, kind), self._installed_last.of(each, kind))
            if self._bundled and not self._is_replaced(each):
                found.update(bundled_names(self.distro, each, kind))
            names.update(f"{each}/{kind}/{name}" for name in found)
        return sorted(names)

    def _load_message(self, name: str) -> Ros2Message:
        package, kind, short_name = split_name(name)
        if kind is Kind.MESSAGE:
            found = self._load(Kind.MESSAGE, package, short_name)
            assert isinstance(found, Ros2Message)
            return found
        if kind is Kind.ACTION:
            self.action(f"{package}/action/{action_of_part(short_name)}")
            if name in self._messages:
                return self._messages[name]
            raise UnknownTypeError(f"{name} is not a message")
        if short_name.endswith(REQUEST_SUFFIX):
            return self.service(f"{package}/srv/{short_name.removesuffix(REQUEST_SUFFIX)}").request
        if short_name.endswith(RESPONSE_SUFFIX):
            return self.service(f"{package}/srv/{short_name.removesuffix(RESPONSE_SUFFIX)}").response
        raise UnknownTypeError(f"{name} is a service, not a message")

    def _load(self, kind: Kind, package: str, name: str) -> Definition:
        file = self._file(kind, package, name)
        if file is not None:
            return parse_file(kind, file, package, name)
        if any(each.has_only_idl(package, kind, name) for each in (self._installed, self._installed_last)):
            raise UnknownTypeError(explain_only_idl(package, kind, name))
        raise UnknownTypeError(
            f"{explain_unknown(self, kind, package, name)} (searched: {self.searched_folders})"
        )

    def _file(self, kind: Kind, package: str, name: str) -> Path | None:
        file = self._own(package, kind).get(name)
        if file is not None and self._is_ros2(file, kind, package):
            return file
        if file := self._installed.of(package, kind).get(name):
            return file
        if self._is_replaced(package) and not self._installed.has_only_idl(package, kind, name):
            return None
        if self._bundled and (file := bundled_names(self.distro, package, kind).get(name)):
            return file
        return self._installed_last.of(package, kind).get(name)

    def _is_replaced(self, package: str) -> bool:
        """Return whether the user's own package hides the bundled one of its name."""
        if any(self._installed.of(package, kind) for kind in Kind):
            return True
        files = self._on_path().get(package)
        return (
            files is not None
            and files.root is not None
            and any(self._is_ros2(file, kind, package) for kind in Kind for file in files.of(kind).values())
        )

    def _is_ros2(self, file: Path, kind: Kind, package: str) -> bool:
        """Return whether a user's file is ROS 2's: by its package.xml, or else by its text."""
        known = self._is_ros2_file.get(file)
        if known is None:
            known = declares_ros2(file)
            if known is None:
                has_header = "Header" in self._own(package, Kind.MESSAGE)
                known = reads_as_ros2(kind, file, package, has_header=has_header)
            self._is_ros2_file[file] = known
        return known

    def _on_path(self) -> dict[str, PackageFiles]:
        if self._found is None:
            self._found = find_definitions(self._paths, self._package_path)
        return self._found

    def _own(self, package: str, kind: Kind) -> Mapping[str, Path]:
        files = self._on_path().get(package)
        return files.of(kind) if files is not None else {}

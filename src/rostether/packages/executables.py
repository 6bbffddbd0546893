"""Finds a package's programs, like rosrun: first in the results of its build, then in the package folder.

A package that was built has its programs in `lib/PACKAGE` of the devel or install space. Scripts need no
build, and can be anywhere below the package's folder.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from rostether.errors import ConfigError
from rostether.mechanisms.text import did_you_mean
from rostether.packages.locate import workspace_of
from rostether.packages.python_scripts import is_module
from rostether.packages.search_path import walk

# Debian's ROS packages have their programs here; no environment variable names this folder.
SYSTEM_LIBRARY_FOLDER = Path("/usr/lib")

_BUILD_FOLDER = "build"

# The CMakeLists.txt of a large package is about 50 KB.
_MAX_CMAKE_BYTES = 1 << 20
_COMPILED = (".cpp", ".cc", ".cxx", ".c")
_EXECUTABLE = re.compile(r"\badd_executable\s*\(\s*([^\s)]+)\s*([^)]*)\)", re.IGNORECASE)

# Linux reads at most this part of a first line.
_MAX_SHEBANG_BYTES = 256
_PYTHON_SUFFIX = ".py"


def find_program(package: str, name: str, folder: Path | None, environ: Mapping[str, str]) -> Path:
    """Return the program of a package.

    `folder` is the package's folder; if it is None, only installed programs are searched. A name with a slash
    is a path below the folder. Python files do not need to be executable. Raises ConfigError if no program
    has the name, if several have it, or if the file is not executable.
    """
    if "/" in name:
        return _given_path(package, name, folder)
    for library in library_folders(package, folder, environ):
        program = library / name
        if program.is_file() and os.access(program, os.X_OK):
            return program
    if folder is None:
        raise _not_found(package)
    # A link and its target are one program.
    found = list({each.resolve(): each for each in _files(folder, name)}.values())
    runnable = [each for each in found if os.access(each, os.X_OK)] or [
        each for each in found if is_python(each)
    ]
    if len(runnable) > 1:
        choices = ", ".join(str(each.relative_to(folder)) for each in runnable)
        raise ConfigError(f"package {package} has several files named {name}; give one of {choices}")
    if runnable:
        return runnable[0]
    if found:
        raise ConfigError(f"{found[0]} is not executable; run `chmod +x {found[0]}`")
    raise ConfigError(_explain_missing(package, name, folder))


def programs(folder: Path) -> list[Path]:
    """Return the files below a package's folder that can be nodes, sorted: executables and Python scripts."""
    return sorted(
        file
        for file in _files(folder)
        if (_is_script(file) if file.suffix == _PYTHON_SUFFIX else os.access(file, os.X_OK))
    )


def _is_script(file: Path) -> bool:
    """Return whether a Python file is a program, not a module; some checkouts mark all files executable."""
    if file.name in ("setup.py", "__init__.py") or (file.parent / "__init__.py").exists():
        return False
    if not shebang(file) and not os.access(file, os.X_OK):
        return False
    return not is_module(file)


def library_folders(package: str, folder: Path | None, environ: Mapping[str, str]) -> Iterator[Path]:
    """Yield the folders that may contain the build results of a package, the most specific first."""
    if folder is not None:
        workspace = workspace_of(folder)
        if workspace is not None:
            yield workspace / "devel" / "lib" / package
            yield workspace / "devel" / ".private" / package / "lib" / package
            yield workspace / "install" / "lib" / package
        # Installed packages: PREFIX/share/PACKAGE has its programs in PREFIX/lib/PACKAGE.
        if folder.parent.name == "share":
            yield folder.parent.parent / "lib" / package
    for prefix in environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix) / "lib" / package
    yield SYSTEM_LIBRARY_FOLDER / package


def is_python(file: Path) -> bool:
    """Return whether a file is a Python script, by its first line, else by its suffix."""
    line = shebang(file)
    return "python" in line if line else file.suffix == _PYTHON_SUFFIX


def shebang(file: Path) -> str:
    """Return the command after `#!` in the first line of a script; empty if there is none."""
    try:
        with file.open("rb") as stream:
            line = stream.read(_MAX_SHEBANG_BYTES).split(b"\n", 1)[0]
    except OSError:
        return ""
    return line[2:].decode(errors="replace").strip() if line.startswith(b"#!") else ""


def _compiled_source(folder: Path, name: str) -> str:
    """Return the source that a program is compiled from, relative to the package's folder; empty if none."""
    try:
        with (folder / "CMakeLists.txt").open("rb") as file:
            text = file.read(_MAX_CMAKE_BYTES).decode(errors="replace")
    except OSError:
        text = ""
    text = re.sub(r"#.*", "", text)
    project = re.search(r"\bproject\s*\(\s*([\w.-]+)", text, re.IGNORECASE)
    if project is not None:
        text = text.replace("${PROJECT_NAME}", project[1])
    renamed = {
        match[2]: match[1] for match in re.finditer(r"\(\s*(\S+)\s+PROPERTIES\s+OUTPUT_NAME\s+\"?(\w+)", text)
    }
    for target, sources in _EXECUTABLE.findall(text):
        if target == renamed.get(name, name):
            words = sources.split()
            return next((each for each in words if Path(each).suffix in _COMPILED), words[0] if words else "")
    files = sorted(each.relative_to(folder) for suffix in _COMPILED for each in _files(folder, name + suffix))
    return str(files[0]) if files else ""


def _given_path(package: str, name: str, folder: Path | None) -> Path:
    if folder is None:
        raise _not_found(package)
    program = folder / name
    if not program.is_file():
        raise ConfigError(f"package {package} has no {name}: {program} does not exist; correct the path")
    if not os.access(program, os.X_OK) and not is_python(program):
        raise ConfigError(f"{program} is not executable; run `chmod +x {program}`")
    return program


def _files(folder: Path, name: str | None = None) -> Iterator[Path]:
    """Yield the files of a package, or only those of one name, without the build folder."""
    for each in walk(folder, below_packages=True):
        if each.path.relative_to(folder).parts[:1] != (_BUILD_FOLDER,):
            names = each.files if name is None else each.files & {name}
            yield from (each.path / file for file in names if (each.path / file).is_file())


def _not_found(package: str) -> ConfigError:
    return ConfigError(
        f"package {package} was not found; put it below this folder, or add its folder to ROS_PACKAGE_PATH"
    )


def _explain_missing(package: str, name: str, folder: Path) -> str:
    if source := _compiled_source(folder, name):
        return (
            f"package {package} has no program {name} yet: it is compiled from {source}; build the workspace "
            "with catkin_make of a ROS 1 installation; rostether then uses the programs in its devel folder"
        )
    names = [each.name for each in programs(folder)]
    if hint := did_you_mean(name, names):
        return f"package {package} has no program {name}; {hint}"
    if names:
        return f"package {package} has no program {name}; it has {', '.join(names)}"
    return f"package {package} has no program {name} below {folder}"

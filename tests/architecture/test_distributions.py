"""The distributions for a package index: the source distribution is the repository, and the README's links
lead there.
"""

from __future__ import annotations

import email
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

REPOSITORY = Path(__file__).parents[2]
PROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
HOME = PROJECT["urls"]["Repository"]
LINK = re.compile(r"\[[^\]]*\]\((?P<target>[^)\s]+)\)")


def build(folder: Path, kind: str, result: Path) -> Path:
    """Build a distribution of a folder; return its file."""
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(result)],
        cwd=folder,
        check=True,
        capture_output=True,
        timeout=120,
    )
    (made,) = result.glob("*.whl" if kind == "wheel" else "*.tar.gz")
    return made


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that a source distribution unpacks to."""
    folder = tmp_path_factory.mktemp("sdist")
    # Python 3.11.2 has no filter for tarfile, and 3.12 warns without one.
    subprocess.run(["tar", "-xzf", str(build(REPOSITORY, "sdist", folder))], cwd=folder, check=True)
    return folder / f"rostether-{PROJECT['version']}"


@pytest.fixture(scope="module")
def wheel(unpacked: Path, tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """The wheel that is built from the source distribution."""
    return zipfile.ZipFile(build(unpacked, "wheel", tmp_path_factory.mktemp("wheel")))


def tracked_files(folder: Path) -> set[Path]:
    """Return the existing files that git tracks or would track."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
    return {path for name in names.split("\0") if name and (folder / (path := Path(name))).is_file()}


def test_the_source_distribution_is_the_repository(unpacked: Path) -> None:
    if not (REPOSITORY / ".git").exists():
        pytest.skip("this is a source distribution")
    packed = {path.relative_to(unpacked) for path in unpacked.rglob("*") if path.is_file()}
    assert packed - {Path("PKG-INFO")} == tracked_files(REPOSITORY)
    for script in (unpacked / "scripts").iterdir():
        assert os.access(script, os.X_OK), script


def test_the_wheel_has_the_package_and_the_client_library(wheel: zipfile.ZipFile, unpacked: Path) -> None:
    package = {path.relative_to(unpacked / "src") for path in (unpacked / "src").rglob("*") if path.is_file()}
    client = {
        "rostether" / path.relative_to(unpacked)
        for path in (unpacked / "client").rglob("*")
        if path.is_file() and path.name != ".gitignore"
    }
    info = {Path(name) for name in wheel.namelist() if ".dist-info/" in name}
    assert {Path(name) for name in wheel.namelist()} - info == package | client
    assert {path.name for path in info} >= {"METADATA", "entry_points.txt", "LICENSE"}


def test_links_of_the_readme_work_on_a_package_index(wheel: zipfile.ZipFile) -> None:
    (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
    metadata = email.message_from_bytes(wheel.read(name))
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert f"Repository, {HOME}" in metadata.get_all("Project-URL", [])
    readme = str(metadata.get_payload())
    targets = [match["target"] for match in LINK.finditer(readme)]
    assert len(targets) == len(LINK.findall((REPOSITORY / "README.md").read_text())) > 5
    for target in targets:
        assert re.match(r"https://", target), f"{target} leads nowhere on a package index"
        if target.startswith(HOME):
            kind, _, path = target.removeprefix(f"{HOME}/").partition("/main/")
            assert kind in ("blob", "raw")
            assert (REPOSITORY / path.partition("#")[0]).exists(), target
    assert f"{HOME}/raw/main/docs/pictures/dashboard.png" in targets


def test_the_repository_has_one_address() -> None:
    for url in PROJECT["urls"].values():
        assert url.startswith(HOME)
    for file in REPOSITORY.glob("src/rostether/**/library.properties"):
        assert f"url={HOME}" in file.read_text().splitlines(), file

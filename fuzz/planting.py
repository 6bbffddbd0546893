"""Applies one planted fault: imports a module of rostether with one piece of its source replaced."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from types import CodeType, ModuleType

from fuzz.plants import Plant

PRODUCT = Path(__file__).parents[1] / "src"


class PlantDoesNotApplyError(Exception):
    """The source has changed: the plant's `old` text must occur in its module exactly once."""


class _PlantedLoader(SourceFileLoader):
    def __init__(self, name: str, path: str, source: str) -> None:
        super().__init__(name, path)
        self._source = source

    def get_code(self, fullname: str) -> CodeType:
        return compile(self._source, self.path, "exec", dont_inherit=True)


class _PlantedFinder(MetaPathFinder):
    def __init__(self, loader: _PlantedLoader) -> None:
        self._loader = loader

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != self._loader.name:
            return None
        return spec_from_file_location(fullname, self._loader.path, loader=self._loader)


def sow(plant: Plant) -> None:
    """Plant the fault in this process, before anything has imported its module.

    Raises PlantDoesNotApplyError.
    """
    path = PRODUCT.joinpath(*plant.module.split(".")).with_suffix(".py")
    source = path.read_text() if path.is_file() else ""
    if source.count(plant.old) != 1:
        raise PlantDoesNotApplyError(
            f"plant {plant.name}: {plant.module} contains {plant.old!r} {source.count(plant.old)} times; "
            "adapt fuzz/plants.py to its source"
        )
    if plant.module in sys.modules:
        raise PlantDoesNotApplyError(f"plant {plant.name}: {plant.module} is imported already")
    planted = source.replace(plant.old, plant.new)
    sys.meta_path.insert(0, _PlantedFinder(_PlantedLoader(plant.module, str(path), planted)))

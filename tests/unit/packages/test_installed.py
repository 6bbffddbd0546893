from __future__ import annotations

from pathlib import Path

from rostether.packages.installed import installed_packages


def test_packages_of_all_prefixes_are_found_and_the_first_counts(tmp_path: Path) -> None:
    for prefix, name in (("over", "arm"), ("under", "arm"), ("under", "base")):
        folder = tmp_path / prefix / "share" / name
        folder.mkdir(parents=True)
        (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (tmp_path / "under/share/doc").mkdir()
    found = installed_packages([tmp_path / "over", tmp_path / "missing", tmp_path / "under"])
    assert found == {"arm": tmp_path / "over/share/arm", "base": tmp_path / "under/share/base"}

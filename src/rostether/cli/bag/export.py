"""`rostether export`: writes the messages of a recording as CSV or Parquet, or its pictures as files."""

from __future__ import annotations

import sys
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.bag.recording_files import create_folder, warn_of_damage
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.interrupts import cleaning_up
from rostether.cli.shell.option_group import PATH, argument, option, option_group
from rostether.cli.shell.output import discard_output, warn, write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.mechanisms.text import counted, misfit_text

if TYPE_CHECKING:
    from rostether.recording.export.exporting import Export, ExportedTable
    from rostether.recording.export.tables import Table

FORMATS = ("csv", "parquet", "pictures")
_STDOUT = "-"


@dataclass(frozen=True, slots=True)
class ExportOptions:
    """The arguments and options of `export`."""

    recording: Path = argument(type=PATH)
    output: str | None = option(
        "-o --output PATH",
        "A folder, a file if there is only one topic, or - for stdout (default: the folder NAME_FORMAT).",
    )
    format_name: str | None = option(
        "--format", "The format (default: from the file's extension, or csv).", type=click.Choice(FORMATS)
    )
    topics: tuple[str, ...] = option(
        "-t --topic TOPIC", "Only this topic; * matches anything.", multiple=True
    )
    fields: tuple[str, ...] = option(
        "-f --field FIELD",
        "Only this field, e.g. pose.position, ranges[0], ranges[:10], or a pattern such as *.x.",
        multiple=True,
    )


@verb(
    "export",
    """
    rostether export drive.bag
    rostether export drive.bag -o tables --format parquet
    rostether export drive.bag --topic /ultrasound -o ultrasound.csv
    rostether export drive.mcap --topic /imu_data --field linear_acceleration --field header.stamp -o -
    rostether export drive.bag --format pictures -o pictures
    rostether export drive.bag --topic "/arm/*" --field "position[0]" --field "*.x"
    """,
)
@option_group("options", ExportOptions)
@cleaning_up()
def export(options: ExportOptions) -> int:
    """Write the messages of RECORDING as tables: one table per topic, one row per message.

    The first columns are the time of recording in seconds and in nanoseconds. Arrays of variable size are
    lists. In CSV, bytes are base64, and texts that a spreadsheet would treat as formulas get an apostrophe in
    front. The format `pictures` writes compressed pictures as .jpg and .png files, in one folder per topic.
    The exit code is 1 if messages are omitted.
    """
    from rostether.recording.export.exporting import Export
    from rostether.recording.export.picture_table import PICTURE_TYPE
    from rostether.recording.files import open_recording

    with closing(open_recording(options.recording)) as reader:
        warn_of_damage(options.recording, reader.damage)
        type_name = PICTURE_TYPE if options.format_name == "pictures" else ""
        chosen = Export(
            reader, topics=options.topics, fields=options.fields, type_name=type_name, report=warn
        )
        files = _TableFiles(options, chosen)
        try:
            chosen.write(files.create)
        except BrokenPipeError:
            discard_output(sys.stdout)
            raise click.exceptions.Exit(EXIT_DONE) from None
        except BaseException:
            files.remove()
            raise
    files.report(chosen.tables)
    return EXIT_FAILED if any(table.unfit_count for table in chosen.tables) else EXIT_DONE


def _is_table_name(output: str) -> bool:
    """Return whether -o names a file. Raises ConfigError for an unknown extension."""
    path = Path(output)
    if path.is_dir() or output.endswith("/"):
        return False
    is_table = path.suffix in (".csv", ".parquet")
    if not is_table and path.suffix[1:2].isalpha():
        raise ConfigError(
            f"-o {output}: the name of a table must end with .csv or .parquet; a folder must exist already, "
            "or have no extension"
        )
    return is_table


def _stem(recording: Path) -> str:
    """Return a recording's name without its extension."""
    path = recording.resolve()
    # The file metadata.yaml selects the ROS 2 bag in its folder.
    name = path.parent.name if path.name == "metadata.yaml" else path.name.removesuffix(".active")
    return str(Path(name).with_suffix(""))


class _TableFiles:
    """The files of the tables, in the requested format."""

    def __init__(self, options: ExportOptions, chosen: Export) -> None:
        output = options.output
        self._created: list[Path] = []
        self._is_stdout = output == _STDOUT
        self._file = Path(output) if output is not None and _is_table_name(output) else None
        extension = self._file.suffix.removeprefix(".") if self._file is not None else None
        self._format = options.format_name or extension or "csv"
        self._folder = Path(f"{_stem(options.recording)}_{self._format}" if output is None else output)
        if (self._is_stdout or self._file is not None) and len(chosen.tables) != 1:
            names = ", ".join(table.topic for table in chosen.tables)
            raise ConfigError(
                f"a file can hold only one topic; choose one with --topic, or give a folder: {names}"
            )
        if self._is_stdout and self._format != "csv":
            raise ConfigError("only CSV can be written to stdout; give a file or a folder with -o")
        if self._file is not None and self._format == "pictures":
            raise ConfigError(f"-o {output}: pictures need a folder; give one with -o")
        if self._format == "parquet":
            from rostether.recording.export.parquet_table import parquet_package

            parquet_package()

    def create(self, table: ExportedTable) -> Table:
        """Create the file of a table, or the folder of pictures. Raises ConfigError, RecordingError."""
        from rostether.recording.export.tables import CsvTable

        if self._is_stdout:
            return CsvTable(sys.stdout, table.columns)
        path = self.path_of(table)
        if self._format == "pictures":
            from rostether.recording.export.picture_table import PictureTable

            return PictureTable(path)
        create_folder(path.parent)
        if self._format == "parquet":
            from rostether.recording.export.parquet_table import ParquetTable

            created: Table = ParquetTable(path, table.columns)
        else:
            created = CsvTable(path, table.columns)
        self._created.append(path)
        return created

    def path_of(self, table: ExportedTable) -> Path:
        """Return the path of a table's file, or of its folder of pictures."""
        name = table.name if self._format == "pictures" else f"{table.name}.{self._format}"
        return self._file or self._folder / name

    def remove(self) -> None:
        """Remove the created tables: an incomplete one looks like a complete one. Pictures are kept."""
        for path in self._created:
            path.unlink(missing_ok=True)

    def report(self, tables: list[ExportedTable]) -> None:
        """Report the written files and the omitted messages."""
        for table in tables:
            if not self._is_stdout:
                rows = f"{counted(table.row_count, 'row')}, {len(table.columns) + 2} columns"
                if self._format == "pictures":
                    rows = counted(table.row_count, "picture")
                write_line(f"{self.path_of(table)}: {rows} of {table.topic}")
            if table.unfit_count:
                warn(f"{table.topic}: {misfit_text(table.unfit_count)}: {table.why}")

"""`rostether doctor --fleet` and `rostether fleet doctor`: why robots do not obey."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import click

from rostether.cli.platform.fleet_options import fleet_options
from rostether.cli.shell.colors import paint_finding
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb

if TYPE_CHECKING:
    from rostether.platform.fleet import FleetSettings


@click.command("doctor", cls=Verb, examples="rostether fleet doctor --interface wlan0 --key-file fleet.key")
@json_option
@fleet_options()
def doctor(as_json: bool, fleet: FleetSettings) -> int:
    """Measure the loss and the signal of each robot, and find ids that two robots have.

    It commands no robot. The exit code is 0 if all robots that answer are healthy, 1 if there is a problem.
    """
    return run(examine_fleet(fleet, as_json=as_json))


async def examine_fleet(settings: FleetSettings, *, as_json: bool) -> int:
    """Print the findings; return the exit code. Raises ConfigError."""
    from rostether.platform.fleet import FleetSender
    from rostether.platform.fleet_findings import disk_finding, fleet_findings

    sender = FleetSender(settings, lambda _, text: warn(text))
    try:
        await sender.query()
    finally:
        sender.close()
    findings = fleet_findings(sender.robots, sender.duplicate_ids(), sender.silence_text())
    disk = shutil.disk_usage(".")
    findings.append(disk_finding("this folder", disk.free, disk.total))
    for finding in findings:
        if as_json:
            write_json({"ok": finding.is_well, "what": finding.what, "text": finding.text})
        else:
            word = "ok" if finding.is_well else "PROBLEM"
            write_line(f"{word}: {finding.what}: {finding.text}", paint_finding)
    return EXIT_DONE if all(each.is_well for each in findings) else EXIT_FAILED

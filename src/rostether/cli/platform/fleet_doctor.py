"""`rostether doctor --fleet` and `rostether fleet doctor`: why robots do not obey."""

from __future__ import annotations

import shutil

from rostether.cli.platform.fleet_options import fleet_options
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import NumberRange, add_option
from rostether.cli.shell.output import json_option, warn, write_finding
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.platform.fleet import FleetSettings, silence_text


@verb(
    "doctor",
    """
    rostether fleet doctor --interface wlan0 --key-file fleet.key
    sudo "$(which rostether)" fleet doctor --duration 130   also listens for the IGMP querier
    """,
)
@add_option(
    "--duration listen_s SECONDS",
    "Listen for an IGMP querier for this time (default: while the robots are asked).",
    type=NumberRange(min=1.0, max=3600.0),
    default=1.0,
)
@json_option
@fleet_options
def doctor(listen_s: float, as_json: bool, fleet: FleetSettings) -> int:
    """Find out why robots do not obey: networks, ids, clocks and disks.

    It measures the loss and the signal of each robot, and compares multicast with unicast. It finds robots
    that do not reach each other, ids that two robots have, clocks that differ, full disks, and (with root)
    networks without an IGMP querier. It commands no robot. The exit code is 1 if there is a problem.
    """
    return run(examine_fleet(fleet, listen_s, as_json=as_json))


async def examine_fleet(settings: FleetSettings, listen_s: float, *, as_json: bool) -> int:
    """Print the findings, after listening for an IGMP querier for `listen_s`; return the exit code.

    Raises ConfigError.
    """
    from rostether.platform.fleet_examination import examine
    from rostether.platform.fleet_findings import disk_finding, fleet_findings

    found = await examine(settings, lambda _, text: warn(text), listen_s)
    findings = fleet_findings(found, silence_text(settings))
    disk = shutil.disk_usage(".")
    findings.append(disk_finding("this folder", disk.free, disk.total))
    for finding in findings:
        write_finding(finding.what, finding.text, is_ok=finding.is_ok, as_json=as_json)
    return EXIT_FAILED if any(each.is_ok is False for each in findings) else EXIT_DONE

"""Opens a zenoh session, and explains failures in plain words."""

from __future__ import annotations

import asyncio

import zenoh

from rostether.errors import ConfigError, MasterUnreachableError
from rostether.ros2.zenoh.configuration import one_line
from rostether.ros2.zenoh.reachability import endpoints_of, find_listen_fault, uses_tls
from rostether.ros2.zenoh.refusals import report_refusals


async def open_session(configuration: zenoh.Config) -> zenoh.Session:
    """Open a session. Raises ConfigError if zenoh refuses the configuration, else MasterUnreachableError."""
    if uses_tls(endpoints_of(configuration, "listen")):
        report_refusals()
    try:
        # Opening blocks until the first connections are established or have failed.
        return await asyncio.to_thread(zenoh.open, configuration)
    except zenoh.ZError as error:
        text = one_line(error)
        if fault := find_listen_fault(configuration):
            raise MasterUnreachableError(f"zenoh cannot listen: {fault}") from error
        if "listener" in text:
            advice = "check the listen endpoints of the configuration"
            if "in use" in text:
                advice = "stop the program that uses the port, or choose another endpoint"
            raise MasterUnreachableError(f"zenoh cannot listen: {text}; {advice}") from error
        raise MasterUnreachableError(f"zenoh cannot open a session: {text}") from error
    except Exception as error:
        raise ConfigError(f"zenoh does not accept its configuration: {one_line(error)}") from error

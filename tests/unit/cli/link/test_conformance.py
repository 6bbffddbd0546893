"""`conformance` as a process, with clients that connect to it."""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys

from interop.ros1_peers import free_port
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import TopicInfo

TIMEOUT_S = 60.0


async def checked(*arguments: str) -> asyncio.subprocess.Process:
    return await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "rostether", "conformance", *arguments),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )


async def announce_forever(port: int) -> None:
    """Run a client that answers all bytes with one announcement, whose md5sum is wrong."""
    info = TopicInfo(125, "chatter", "std_msgs/String", "0" * 32, 280)
    while True:
        try:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
        except OSError:
            await asyncio.sleep(0.02)
            continue
        # The command closes a connection while an announcement is in transit.
        with contextlib.suppress(ConnectionError):
            while await reader.read(1024):
                writer.write(encode_frame(ids.PUBLISHER, info.encode()))
        writer.close()


async def test_a_failed_case_is_reported_with_the_observed_packets() -> None:
    port = free_port()
    client = asyncio.create_task(announce_forever(port))
    names = ("announce-names", "announce-md5sums", "frame-check")
    process = await checked(f"tcp://127.0.0.1:{port}", "--json", *(f"--case={name}" for name in names))
    out, err = await asyncio.wait_for(process.communicate(), TIMEOUT_S)
    client.cancel()
    assert (process.returncode, err) == (1, b"")
    *cases, total = map(json.loads, out.splitlines())
    assert [(each["case"], each["verdict"]) for each in cases] == [
        ("announce-names", "pass"),
        ("announce-md5sums", "fail"),
        ("frame-check", "not applicable"),
    ]
    assert "has 00000000" in cases[1]["seen"]
    assert "needs conformance/text_in" in cases[2]["seen"]
    assert total == {"passed": 1, "failed": 1, "not_applicable": 1}


async def test_wrong_arguments_are_refused_in_one_line() -> None:
    for arguments, reported in (
        ((), b"give the client's address"),
        (("tcp://:1", "--case", "nothing"), b"no case nothing; --list shows the cases"),
    ):
        process = await checked(*arguments)
        _, err = await asyncio.wait_for(process.communicate(), TIMEOUT_S)
        assert process.returncode == 2
        assert reported in err

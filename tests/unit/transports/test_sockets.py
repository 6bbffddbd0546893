from __future__ import annotations

import asyncio
import contextlib
import errno
import gc
import os
import socket

import pytest

from rostether.transports.sockets import (
    close_servers,
    explain_bind_error,
    explain_connect_error,
    explain_reason,
    start_server,
    tune_stream,
)


@pytest.mark.parametrize(
    ("host", "code", "reported"),
    [
        ("127.0.0.1", errno.EADDRINUSE, "port 80 is already in use on 127.0.0.1; stop"),
        ("127.0.0.1", errno.EADDRINUSE, "choose another port with tcp://:PORT"),
        ("0.0.0.0", errno.EADDRINUSE, "choose another port with tcp://0.0.0.0:PORT"),
        ("10.9.9.9", errno.EADDRNOTAVAIL, "write tcp://0.0.0.0:80 to listen on all its addresses"),
        ("127.0.0.1", errno.EACCES, "port 80 is reserved for the system"),
        ("::1", errno.EMFILE, "cannot listen on [::1]:80: too many files; check the host"),
    ],
)
def test_why_a_port_cannot_be_listened_on(host: str, code: int, reported: str) -> None:
    assert reported in str(explain_bind_error("tcp", host, 80, OSError(code, "too many files")))


@pytest.mark.parametrize("host", ["192.0.2.1", "2001:db8::1"])
async def test_a_foreign_address_is_named_by_the_system(host: str) -> None:
    with pytest.raises(OSError) as caught:
        await start_server(asyncio.Protocol, host, 0, accepted_at_once=1)
    assert (caught.value.errno, caught.value.strerror) == (
        errno.EADDRNOTAVAIL,
        os.strerror(errno.EADDRNOTAVAIL),
    )


async def test_an_error_without_a_number_is_replaced_by_that_of_the_system(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def fail_as_python_3_13(*_: object, **__: object) -> None:
        raise OSError("could not bind on any address out of [('192.0.2.1', 0)]")

    monkeypatch.setattr(asyncio.get_running_loop(), "create_server", fail_as_python_3_13)
    with pytest.raises(OSError) as caught:
        await start_server(asyncio.Protocol, "192.0.2.1", 0, accepted_at_once=1)
    assert caught.value.errno == errno.EADDRNOTAVAIL


async def test_a_port_in_use_is_reported_in_the_words_of_the_system() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(OSError) as caught:
            await start_server(asyncio.Protocol, "127.0.0.1", port, accepted_at_once=1)
    assert (caught.value.errno, caught.value.strerror) == (errno.EADDRINUSE, os.strerror(errno.EADDRINUSE))


async def test_a_host_without_an_address_is_an_error_of_the_resolver() -> None:
    with pytest.raises(socket.gaierror):
        await start_server(asyncio.Protocol, "no such host", 0, accepted_at_once=1)


@pytest.mark.parametrize(
    ("error", "reported"),
    [
        (ConnectionRefusedError(errno.ECONNREFUSED, "refused"), "no program listens on robot:1"),
        (socket.gaierror(-2, "Name or service not known"), "the host of robot:1 is unknown;"),
        (OSError(errno.EHOSTUNREACH, "No route to host"), "cannot reach robot:1: No route to host"),
    ],
)
def test_why_a_peer_cannot_be_reached(error: OSError, reported: str) -> None:
    assert reported in str(explain_connect_error("robot:1", error))


def test_the_text_of_an_error() -> None:
    assert explain_reason(OSError(5, "Input/output error", "/dev/x")) == "Input/output error"
    assert explain_reason(ValueError("odd")) == "odd"
    assert explain_reason(ValueError()) == "ValueError"


async def test_a_failed_connection_has_the_text_of_the_system() -> None:
    with pytest.raises(OSError) as caught:
        await asyncio.get_running_loop().create_connection(asyncio.Protocol, "127.0.0.1", 1)
    assert explain_reason(caught.value) == os.strerror(errno.ECONNREFUSED)
    each = "[Errno 111] Connect call failed ('::1', 1, 0, 0)"
    several = OSError(f"Multiple exceptions: {each}, [Errno 111] Connect call failed ('127.0.0.1', 1)")
    assert explain_reason(several) == os.strerror(111)
    assert "no program listens on host:1; start it" in str(explain_connect_error("host:1", several))


@pytest.mark.parametrize("reason", [errno.ECONNREFUSED, errno.EHOSTUNREACH])
def test_an_address_without_ipv6_does_not_hide_why_ipv4_failed(reason: int) -> None:
    ipv6 = f"[Errno {errno.EADDRNOTAVAIL}] Cannot assign requested address"
    several = OSError(f"Multiple exceptions: {ipv6}, [Errno {reason}] Connect call failed ('127.0.0.1', 1)")
    assert explain_reason(several) == os.strerror(reason)


@pytest.mark.skipif(not hasattr(socket, "TCP_KEEPIDLE"), reason="this system has no such option")
def test_a_peer_that_disappears_is_detected_within_about_eleven_seconds() -> None:
    with socket.socket() as sock:
        tune_stream(sock)
        idle, interval, probes = (
            sock.getsockopt(socket.IPPROTO_TCP, option)
            for option in (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT)
        )
    assert idle + interval * probes == 11


@pytest.mark.skipif(not hasattr(socket, "TCP_NOTSENT_LOWAT"), reason="this system has no such option")
def test_unread_data_for_a_slow_board_waits_in_this_process() -> None:
    with socket.socket() as sock:
        tune_stream(sock)
        assert sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT) == 16 * 1024


@pytest.mark.parametrize("turns", range(6))
async def test_a_start_that_is_cancelled_at_any_moment_leaves_no_port_open(turns: int) -> None:
    starting = asyncio.create_task(start_server(asyncio.Protocol, "127.0.0.1", 0, accepted_at_once=1))
    for _ in range(turns):
        await asyncio.sleep(0)
    starting.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await close_servers([await starting])
    # An open socket would raise a ResourceWarning.
    del starting
    gc.collect()

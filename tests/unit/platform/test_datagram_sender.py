from __future__ import annotations

import errno
import socket

import pytest

from rostether.platform import datagram_sender
from rostether.platform.datagram_sender import DatagramSender
from rostether.platform.multicast_socket import open_sender
from unit.platform.datagrams import PlainReceiver, loopback_group
from unit.platform.typed_nodes import Lines
from waiting import until


class GoneInterface(socket.socket):
    """A socket whose network interface was unplugged; a new interface with the same name is another one for
    the system.
    """

    def sendto(self, *_: object) -> int:
        raise OSError(errno.ENODEV, "No such device")


async def test_an_interface_that_was_unplugged_and_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    address, lines = loopback_group(), Lines()
    receiver = PlainReceiver(address)
    gone = GoneInterface(socket.AF_INET, socket.SOCK_DGRAM)
    sockets = [gone, open_sender(address, "lo")]
    monkeypatch.setattr(datagram_sender, "open_sender", lambda *_: sockets.pop(0))
    sender = DatagramSender(address, lines, on_datagram=lambda *_: None)
    assert not sender.send(b"lost")
    assert gone.fileno() == -1
    assert sender.send(b"sent")
    await until(lambda: receiver.datagrams == [b"sent"])
    assert lines.texts[0].startswith(f"cannot send to {address} by lo: No such device; trying again.")
    assert lines.texts[1:] == [f"sending to {address} again"]
    sender.close()
    receiver.close()

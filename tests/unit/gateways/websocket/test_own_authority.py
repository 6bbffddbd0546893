from __future__ import annotations

import asyncio
import datetime
import importlib
import ipaddress
import os
import socket
import ssl
import stat
import sys
from pathlib import Path

import pytest
from cryptography import x509

from rostether.errors import ConfigError
from rostether.gateways.websocket import own_authority
from rostether.gateways.websocket.own_authority import OwnCertificate, own_certificate
from rostether.transports.address import TlsFiles
from rostether.transports.tls import listener_context


async def greeted(made: OwnCertificate, name: str) -> None:
    """Connect by TLS to a name, like a device that trusts the authority."""
    server = await asyncio.start_server(
        lambda _, writer: writer.close(),
        "127.0.0.1",
        0,
        ssl=listener_context(TlsFiles(str(made.certificate), str(made.key))),
    )
    trust = ssl.create_default_context(cafile=str(made.authority))
    try:
        port = server.sockets[0].getsockname()[1]
        reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=trust, server_hostname=name)
        await reader.read()
        writer.close()
        await writer.wait_closed()
    finally:
        server.close()
        await server.wait_closed()


async def test_a_device_that_trusts_the_authority_trusts_the_server(tmp_path: Path) -> None:
    made = own_certificate(tmp_path / "tls", ["Robot.lan", "192.168.7.1", ""])
    label = socket.gethostname().partition(".")[0].lower()
    for name in ("localhost", "127.0.0.1", label, f"{label}.local", "robot.lan", "192.168.7.1"):
        await greeted(made, name)
    with pytest.raises(ssl.SSLCertVerificationError):
        await greeted(made, "bank.example")


def test_other_users_cannot_read_the_keys(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        made = own_certificate(tmp_path / "tls")
    finally:
        os.umask(before)
    assert stat.S_IMODE(made.authority.stat().st_mode) == 0o644
    for key in (made.key, tmp_path / "tls" / "authority.key"):
        assert stat.S_IMODE(key.stat().st_mode) == 0o600
    assert stat.S_IMODE((tmp_path / "tls").stat().st_mode) == 0o700


@pytest.mark.parametrize("stale", ["server.key", "authority.key"])
def test_files_of_a_program_that_was_killed_between_them_are_made_again(tmp_path: Path, stale: str) -> None:
    own_certificate(tmp_path / "other")
    made = own_certificate(tmp_path / "tls")
    (tmp_path / "other" / stale).replace(tmp_path / "tls" / stale)
    assert own_certificate(tmp_path / "tls") == made
    assert listener_context(TlsFiles(str(made.certificate), str(made.key)))
    authority = x509.load_pem_x509_certificate(made.authority.read_bytes())
    x509.load_pem_x509_certificate(made.certificate.read_bytes()).verify_directly_issued_by(authority)


def test_a_name_that_no_certificate_can_have_is_named(tmp_path: Path) -> None:
    assert own_certificate(tmp_path, ["röbot.local"])
    with pytest.raises(ConfigError, match=r"'a\.\.b' is not a host name; correct ROS_HOSTNAME"):
        own_certificate(tmp_path, ["a..b"])


def test_the_authority_signs_for_this_machine_and_local_networks_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = {ipaddress.ip_address(each) for each in ("127.0.0.1", "203.0.113.9", "2001:4860::1")}
    monkeypatch.setattr(own_authority, "own_addresses", lambda: own)
    made = own_certificate(tmp_path)
    authority = x509.load_pem_x509_certificate(made.authority.read_bytes())
    constraints = authority.extensions.get_extension_for_class(x509.NameConstraints)
    assert constraints.critical
    permitted = constraints.value.permitted_subtrees or []
    networks = [str(each.value) for each in permitted if isinstance(each, x509.IPAddress)]
    assert set(networks) - set(own_authority._LOCAL_NETWORKS) == {"203.0.113.9/32"}
    server = x509.load_pem_x509_certificate(made.certificate.read_bytes())
    names = server.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert set(names.get_values_for_type(x509.IPAddress)) == {
        ipaddress.ip_address("127.0.0.1"),
        ipaddress.ip_address("203.0.113.9"),
    }
    own.add(ipaddress.ip_address("203.0.113.10"))
    other = own_certificate(tmp_path)
    assert x509.load_pem_x509_certificate(other.authority.read_bytes()) != authority


def test_it_stays_until_something_changes(tmp_path: Path) -> None:
    def contents() -> tuple[bytes, bytes]:
        made = own_certificate(tmp_path, names)
        return made.authority.read_bytes(), made.certificate.read_bytes()

    names = ["localhost"]
    first = contents()
    assert contents() == first
    names.append("192.168.7.1")
    second = contents()
    assert second[0] == first[0]
    assert second[1] != first[1]
    # If the authority may not sign for a name, a new authority is necessary.
    names.append("robot.lan")
    third = contents()
    assert third[0] != second[0]
    assert third[1] != second[1]


def test_it_is_renewed_before_it_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = own_certificate(tmp_path).certificate.read_bytes()
    later = datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=365)
    monkeypatch.setattr(own_authority, "_now", lambda: later)
    assert own_certificate(tmp_path).certificate.read_bytes() != first


def test_a_damaged_certificate_is_made_again_but_not_its_authority(tmp_path: Path) -> None:
    made = own_certificate(tmp_path)
    authority = made.authority.read_bytes()
    for file in (made.certificate, made.key):
        file.write_text("")
        assert own_certificate(tmp_path) == made
        assert listener_context(TlsFiles(str(made.certificate), str(made.key)))
    assert made.authority.read_bytes() == authority
    made.authority.write_text("nonsense")
    with pytest.raises(ConfigError, match=r"authority\.pem or authority\.key in .* is damaged; delete both"):
        own_certificate(tmp_path)


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be made: Not a directory; make the folder writable"):
        own_certificate(tmp_path / "file" / "tls")


def test_the_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cryptography", None)
    monkeypatch.delitem(sys.modules, own_authority.__name__)
    with pytest.raises(ConfigError, match=r"'rostether\[tls\]'"):
        importlib.import_module(own_authority.__name__)

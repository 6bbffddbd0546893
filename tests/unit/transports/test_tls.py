"""The files of TLS: each fault is one line, without a question on the terminal."""

from __future__ import annotations

import datetime
import shutil
import ssl
import subprocess
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID

from rostether.errors import ConfigError
from rostether.transports.tls import load_own_certificate


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two certificates, of which one has a key with a password."""
    if shutil.which("openssl") is None:
        pytest.skip("needs openssl to make certificates")
    folder = tmp_path_factory.mktemp("certificates")
    for name, secret in (("plain", ["-nodes"]), ("locked", ["-passout", "pass:secret"])):
        subprocess.run(
            [
                *("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"),
                *("-days", "2", "-subj", f"/CN={name}", *secret),
                *("-keyout", folder / f"{name}.key", "-out", folder / f"{name}.pem"),
            ],
            check=True,
            capture_output=True,
        )
    (folder / "both.pem").write_bytes(
        b"".join((folder / f"plain.{end}").read_bytes() for end in ("pem", "key"))
    )
    (folder / "torn.pem").write_bytes((folder / "plain.pem").read_bytes()[:200])
    (folder / "torn_both.pem").write_bytes(
        (folder / "torn.pem").read_bytes() + (folder / "plain.key").read_bytes()
    )
    return folder


@pytest.mark.parametrize(
    ("certificate", "key", "reason"),
    [
        ("none.pem", "plain.key", r"cannot read .*none\.pem: No such file or directory; check the path"),
        ("plain.pem", "none.key", r"cannot read .*none\.key: No such file or directory; check the path"),
        ("plain.key", "plain.pem", r"plain\.key contains no certificate in PEM format"),
        ("plain.pem", None, r"plain\.pem contains no private key in PEM format; add it, or give its file"),
        ("plain.pem", "locked.key", r"the key \S*locked\.key has a password; remove it: openssl pkey -in "),
        ("locked.pem", "plain.key", r"plain\.key is not the key of the certificate \S*locked\.pem"),
        ("torn.pem", "plain.key", r"torn\.pem or \S*plain\.key is damaged; create the certificate"),
        ("torn_both.pem", None, r"^\S*torn_both\.pem is damaged; create the certificate and its key again$"),
    ],
)
def test_a_file_that_cannot_be_used_is_named(
    files: Path, certificate: str, key: str | None, reason: str
) -> None:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    with pytest.raises(ConfigError, match=reason):
        load_own_certificate(context, str(files / certificate), key and str(files / key))


def test_one_file_may_contain_both(files: Path) -> None:
    load_own_certificate(ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER), str(files / "both.pem"), None)


@pytest.mark.parametrize(
    ("days", "fault"), [(-9, "certificate has expired"), (9, "certificate is not yet valid"), (0, "")]
)
def test_wrong_dates_are_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, days: int, fault: str
) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "bridge")])
    begin = datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=days - 1)
    certificate = (
        x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number())
        .not_valid_before(begin)
        .not_valid_after(begin + datetime.timedelta(days=3))
        .sign(key, hashes.SHA256())
    )
    file = tmp_path / "both.pem"
    file.write_bytes(
        certificate.public_bytes(Encoding.PEM)
        + key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    )
    load_own_certificate(ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER), str(file), None)
    wanted = [f"{file}: {fault}; replace it, or set the clock of this machine"] if fault else []
    assert caplog.messages == wanted

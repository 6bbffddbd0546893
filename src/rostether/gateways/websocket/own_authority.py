"""Certificates for a robot's own web pages, signed by a certificate authority of this machine.

A device that installs the authority's certificate trusts only the pages of this machine: the
authority may only sign for this machine's names and addresses, and for addresses of local networks.
"""

from __future__ import annotations

import datetime
import ipaddress
import socket
from collections.abc import Iterable
from pathlib import Path
from typing import TypeAlias

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.extras import install_command
from rostether.mechanisms.whole_file import write_whole
from rostether.transports.own_names import own_addresses

try:
    from cryptography import x509
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import (
        Encoding,
        NoEncryption,
        PrivateFormat,
        load_pem_private_key,
    )
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID
except ImportError:
    raise ConfigError(f"--tls auto needs another package; run: {install_command('tls')}") from None

_Address: TypeAlias = ipaddress.IPv4Address | ipaddress.IPv6Address

# Ten years, longer than a robot is in use: a new authority must be installed on each device again.
_AUTHORITY_DAYS = 3650
# Browsers refuse certificates of servers that are valid for more than 398 days.
_SERVER_DAYS = 390
# A machine that is off for some weeks still has a valid certificate when it starts.
_RENEW_DAYS = 30
# Two programs of one robot that start together may each replace the files of the other.
_ATTEMPTS = 10
# RFC 1918 (private), 6598 (carriers), 1122 (loopback), 3927 (link-local), 4291 and 4193 (IPv6).
_LOCAL_NETWORKS = (
    "10.0.0.0/8",
    "100.64.0.0/10",
    "127.0.0.0/8",
    "169.254.0.0/16",
    "172.16.0.0/12",
    "192.168.0.0/16",
    "::1/128",
    "fc00::/7",
    "fe80::/10",
)


class OwnCertificate(Struct, frozen=True):
    """Files of a server's certificate with its key, and of the authority's certificate for other devices."""

    certificate: Path
    key: Path
    authority: Path


def own_certificate(folder: Path, names: Iterable[str] = ()) -> OwnCertificate:
    """Return this machine's certificate from a folder; make or renew it if needed.

    Args:
        folder: Also contains the authority; only this user can read the keys.
        names: Names and addresses of the page, in addition to those that are found.

    Raises ConfigError if a name is invalid, or the files are damaged or not writable.
    """
    wanted_names, addresses = _identities(names)
    made = OwnCertificate(folder / "server.pem", folder / "server.key", folder / "authority.pem")
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        for _ in range(_ATTEMPTS):
            authority, key = _authority(folder, wanted_names, addresses)
            if _is_valid(made, authority, wanted_names, addresses):
                return made
            _make_server_certificate(made, authority, key, wanted_names, addresses)
    except OSError as error:
        raise ConfigError(
            f"the certificate in {folder} cannot be made: {error.strerror or error}; make the folder "
            "writable for this user, or use --tls with your own certificate"
        ) from None
    except ValueError:
        raise ConfigError(
            f"authority.pem or authority.key in {folder} is damaged; delete both to make a new authority, "
            "which devices must trust again"
        ) from None
    raise ConfigError(f"another program is changing the certificates in {folder}; try again")


def _identities(names: Iterable[str]) -> tuple[set[str], set[_Address]]:
    label = socket.gethostname().partition(".")[0].lower() or "robot"
    hosts, addresses = {"localhost", label, f"{label}.local"}, own_addresses()
    for name in names:
        try:
            addresses.add(ipaddress.ip_address(name))
        except ValueError:
            if name:
                hosts.add(_ascii_name(name))
    # Public IPv6 addresses change daily, and each new address would need another authority.
    return hosts, {each for each in addresses if each.version == 4 or _is_local(each)}


def _ascii_name(name: str) -> str:
    """Return a host name in the ASCII form of certificates. Raises ConfigError."""
    try:
        return name.lower().encode("idna").decode()
    except UnicodeError:
        raise ConfigError(f"{name!r:.200} is not a host name; correct ROS_HOSTNAME or --listen") from None


def _is_local(address: _Address) -> bool:
    return any(address in ipaddress.ip_network(network) for network in _LOCAL_NETWORKS)


def _authority(
    folder: Path, names: set[str], addresses: set[_Address]
) -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
    certificate_file, key_file = folder / "authority.pem", folder / "authority.key"
    if certificate_file.exists() and key_file.exists():
        certificate = x509.load_pem_x509_certificate(certificate_file.read_bytes())
        key = load_pem_private_key(key_file.read_bytes(), None)
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise ValueError("its key is of another kind")
        is_valid = certificate.not_valid_after_utc > _now() + datetime.timedelta(days=_SERVER_DAYS)
        is_valid = is_valid and certificate.public_key() == key.public_key()
        if is_valid and _may_sign(certificate, names, addresses):
            return certificate, key
    key = ec.generate_private_key(ec.SECP256R1())
    name = _named(f"rostether on {socket.gethostname()}"[:64])
    permitted: list[x509.GeneralName] = [x509.DNSName(each) for each in sorted(names)]
    own = [str(each) for each in sorted(addresses, key=str) if not _is_local(each)]
    permitted += [x509.IPAddress(ipaddress.ip_network(each)) for each in (*_LOCAL_NETWORKS, *own)]
    builder = (
        _certificate_builder(name, name, key, _AUTHORITY_DAYS, is_authority=True)
        .add_extension(x509.NameConstraints(permitted, None), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
    )
    certificate = builder.sign(key, hashes.SHA256())
    _write_pair(key_file, key, certificate_file, certificate)
    return certificate, key


def _make_server_certificate(
    made: OwnCertificate,
    authority: x509.Certificate,
    authority_key: ec.EllipticCurvePrivateKey,
    names: set[str],
    addresses: set[_Address],
) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    identities: list[x509.GeneralName] = [x509.DNSName(each) for each in sorted(names)]
    identities += [x509.IPAddress(each) for each in sorted(addresses, key=str)]
    signer = x509.AuthorityKeyIdentifier.from_issuer_public_key(authority_key.public_key())
    builder = (
        _certificate_builder(_named("rostether"), authority.subject, key, _SERVER_DAYS, is_authority=False)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .add_extension(x509.SubjectAlternativeName(identities), critical=False)
        .add_extension(signer, critical=False)
    )
    certificate = builder.sign(authority_key, hashes.SHA256())
    _write_pair(made.key, key, made.certificate, certificate)


def _is_valid(
    made: OwnCertificate, authority: x509.Certificate, names: set[str], addresses: set[_Address]
) -> bool:
    if not made.certificate.exists() or not made.key.exists():
        return False
    try:
        certificate = x509.load_pem_x509_certificate(made.certificate.read_bytes())
        certificate.verify_directly_issued_by(authority)
        key = load_pem_private_key(made.key.read_bytes(), None)
    except (InvalidSignature, ValueError):
        # Files that were being written when the power failed may be empty.
        return False
    # Only one of the two files is new if the program was killed between the writes.
    if key.public_key() != certificate.public_key():
        return False
    held = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    return (
        certificate.not_valid_after_utc > _now() + datetime.timedelta(days=_RENEW_DAYS)
        and names <= set(held.get_values_for_type(x509.DNSName))
        and addresses <= set(held.get_values_for_type(x509.IPAddress))
    )


def _may_sign(authority: x509.Certificate, names: set[str], addresses: set[_Address]) -> bool:
    try:
        constraints = authority.extensions.get_extension_for_class(x509.NameConstraints).value
    except x509.ExtensionNotFound:
        return False
    permitted = constraints.permitted_subtrees or []
    hosts = {each.value for each in permitted if isinstance(each, x509.DNSName)}
    networks = [each.value for each in permitted if isinstance(each, x509.IPAddress)]
    return names <= hosts and all(
        any(
            isinstance(network, ipaddress.IPv4Network | ipaddress.IPv6Network) and address in network
            for network in networks
        )
        for address in addresses
    )


def _named(name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])


def _certificate_builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePrivateKey, days: int, *, is_authority: bool
) -> x509.CertificateBuilder:
    usage = x509.KeyUsage(
        digital_signature=not is_authority,
        key_cert_sign=is_authority,
        crl_sign=is_authority,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        encipher_only=False,
        decipher_only=False,
    )
    constraints = x509.BasicConstraints(ca=is_authority, path_length=0 if is_authority else None)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(_now() - datetime.timedelta(days=1))
        .not_valid_after(_now() + datetime.timedelta(days=days))
        .add_extension(constraints, critical=True)
        .add_extension(usage, critical=True)
    )


def _write_pair(
    key_file: Path, key: ec.EllipticCurvePrivateKey, certificate_file: Path, certificate: x509.Certificate
) -> None:
    # Other users must not be able to read it.
    write_whole(key_file, key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()), mode=0o600)
    write_whole(certificate_file, certificate.public_bytes(Encoding.PEM), mode=0o644)


def _now() -> datetime.datetime:
    return datetime.datetime.now(datetime.UTC)

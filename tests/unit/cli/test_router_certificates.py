"""Zenoh routers with TLS configured by files: both sides report why a connection fails."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

from interop.ros1_peers import free_port
from programs import start_command

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl (apt install openssl)"),
]

KEY = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
AUTHORITY = """
[ca]
default_ca = trusted
[trusted]
database = issued
new_certs_dir = .
default_md = sha256
rand_serial = yes
policy = names
[names]
commonName = supplied
"""
TRUSTED: dict[str, object] = {"root_ca_certificate": "trusted.pem"}


def run(folder: Path, *arguments: str) -> None:
    subprocess.run(["openssl", *arguments], cwd=folder, check=True, capture_output=True)


def certify(folder: Path, name: str, authority: str, *, host: str = "localhost", until: str = "") -> None:
    run(folder, "req", *KEY, "-subj", f"/CN={name}", "-keyout", f"{name}.key", "-out", f"{name}.csr")
    (folder / "ext").write_text(f"subjectAltName=DNS:{host}")
    if until:
        # `openssl x509` of OpenSSL 3.0 cannot set dates.
        (folder / "issued").write_text("")
        (folder / "ca.cnf").write_text(AUTHORITY)
        run(
            folder,
            *(
                "ca",
                "-batch",
                "-config",
                "ca.cnf",
                "-cert",
                f"{authority}.pem",
                "-keyfile",
                f"{authority}.key",
            ),
            *("-in", f"{name}.csr", "-extfile", "ext", "-notext", "-out", f"{name}.pem"),
            *("-startdate", "20200101000000Z", "-enddate", until),
        )
        return
    signed = ("-CA", f"{authority}.pem", "-CAkey", f"{authority}.key", "-CAcreateserial")
    run(
        folder,
        *("x509", "-req", "-days", "1", "-in", f"{name}.csr", *signed, "-extfile", "ext"),
        *("-out", f"{name}.pem"),
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certificates")
    for authority in ("trusted", "others"):
        subject = ("-subj", f"/CN={authority}")
        run(
            folder,
            *("req", "-x509", *KEY, "-days", "1", *subject),
            *("-keyout", f"{authority}.key", "-out", f"{authority}.pem"),
        )
    for name, authority in (("robot", "trusted"), ("laptop", "trusted"), ("stranger", "others")):
        certify(folder, name, authority)
    certify(folder, "elsewhere", "trusted", host="elsewhere")
    certify(folder, "expired", "trusted", until="20200201000000Z")
    return folder


def configured(folder: Path, name: str, tls: dict[str, object], **endpoints: list[str]) -> dict[str, str]:
    """Write a router's configuration; return the environment that names it."""
    files = {
        key: str(folder / str(value)) if str(value).endswith((".pem", ".key", "ext")) else value
        for key, value in tls.items()
    }
    path = folder / f"{name}.json5"
    path.write_text(
        json.dumps(
            {
                "mode": "router",
                "listen": {"endpoints": endpoints["listen"]},
                "connect": {"endpoints": endpoints.get("connect", []), "exit_on_failure": False},
                "scouting": {"multicast": {"enabled": False}},
                "timestamping": {"enabled": True},
                "transport": {"link": {"tls": files}},
            }
        )
    )
    # An override keeps the sessions of these tests away from other routers.
    return {"ZENOH_ROUTER_CONFIG_URI": str(path), "ZENOH_CONFIG_OVERRIDE": ""}


def trusted(name: str) -> dict[str, object]:
    return {
        **TRUSTED,
        "enable_mtls": True,
        "connect_certificate": f"{name}.pem",
        "connect_private_key": f"{name}.key",
    }


@pytest.mark.parametrize(
    ("tls", "here", "there", "robot_certificate"),
    [
        (trusted("laptop"), "", "", "robot"),
        (
            trusted("stranger"),
            "it refuses the client certificate",
            "its certificate is not from the configured authority",
            "robot",
        ),
        (TRUSTED, "it asks for a certificate", "it has no certificate", "robot"),
        (
            {"root_ca_certificate": "others.pem"},
            "others.pem is not its authority",
            "it does not know the authority",
            "robot",
        ),
        ({}, "no authority is given", "it does not know the authority", "robot"),
        (
            trusted("laptop") | {"connect_private_key": "stranger.key"},
            "stranger.key is not the key of the certificate",
            "",
            "robot",
        ),
        (TRUSTED | {"root_ca_certificate": "none.pem"}, "none.pem cannot be read (No such file", "", "robot"),
        (
            trusted("expired"),
            "refuses the client certificate",
            "its certificate has expired (invalid",
            "robot",
        ),
        (
            trusted("laptop"),
            "(certificate has expired); renew it, or set the clock",
            "this machine's certificate has expired (received fatal alert: CertificateExpired); renew it",
            "expired",
        ),
        (
            trusted("laptop"),
            "its certificate is for another machine (Hostname mismatch",
            "it does not accept this machine's certificate (received fatal alert: BadCertificate); check",
            "elsewhere",
        ),
    ],
)
async def test_both_sides_report_the_reason(
    folder: Path, tls: dict[str, object], here: str, there: str, robot_certificate: str
) -> None:
    port, tcp_port = free_port(), free_port()
    robot = {
        **TRUSTED,
        "enable_mtls": True,
        "listen_certificate": f"{robot_certificate}.pem",
        "listen_private_key": f"{robot_certificate}.key",
    }
    listening = [f"tcp/localhost:{tcp_port}", f"tls/0.0.0.0:{port}"]
    router = await start_command(
        "core", "--ros2", "zenoh", environment=configured(folder, "robot", robot, listen=listening)
    )
    places = {"listen": [f"tcp/localhost:{free_port()}"], "connect": [f"tls/localhost:{port}"]}
    variables = configured(folder, "other", tls, **places)
    try:
        await router.wait_for(f"Other machines can reach it at tls/0.0.0.0:{port}")
        assert "Only this machine" not in router.text
        await router.wait_for("Press Ctrl-C")
        # On a busy machine the router may answer too late.
        for _ in range(5):
            doctor = await start_command("doctor", "--ros2", "zenoh", environment=variables)
            text = await doctor.finish()
            if (here or ": answers") in text:
                break
        if not here:
            assert f"ok: tls/localhost:{port} in {folder}/other.json5: answers" in text
            return
        assert f"PROBLEM: tls/localhost:{port} in {folder}/other.json5: " in text
        assert here in text
        assert doctor.process.returncode == 1
        other = await start_command("core", "--ros2", "zenoh", environment=variables)
        try:
            await other.wait_for(f"no zenoh router answers at tls/localhost:{port} yet")
            await other.wait_for(here)
            if there:
                await router.wait_for(f"refused a TLS connection: {there}")
            assert "ThreadId" not in router.text
        finally:
            await other.stop(signal.SIGTERM)
    finally:
        await router.stop(signal.SIGTERM)


async def test_the_wrong_protocol(folder: Path) -> None:
    port, tcp_port = free_port(), free_port()
    robot = {**TRUSTED, "listen_certificate": "robot.pem", "listen_private_key": "robot.key"}
    listening = [f"tcp/localhost:{tcp_port}", f"tls/localhost:{port}"]
    router = await start_command(
        "core", "--ros2", "zenoh", environment=configured(folder, "both", robot, listen=listening)
    )
    connecting = [f"tcp/localhost:{port}", f"tls/localhost:{tcp_port}"]
    variables = configured(folder, "wrong", TRUSTED, listen=[], connect=connecting)
    try:
        await router.wait_for("Press Ctrl-C")
        doctor = await start_command("doctor", "--ros2", "zenoh", environment=variables)
        text = await doctor.finish()
        assert f"PROBLEM: tcp/localhost:{port} in {folder}/wrong.json5: zenoh cannot connect to it" in text
        assert (
            f"PROBLEM: tls/localhost:{tcp_port} in {folder}/wrong.json5: it accepts connections, but" in text
        )
        await router.wait_for("refused a TLS connection: it does not speak TLS")
        # The doctor's test of the port is not a refusal.
        assert "handshake eof" not in router.text
    finally:
        await router.stop(signal.SIGTERM)


@pytest.mark.parametrize(
    ("tls", "fault"),
    [
        ({}, "TLS needs a certificate and its key"),
        (
            {"listen_certificate": "robot.pem", "listen_private_key": "none.key"},
            "none.key cannot be read (No such file or directory); check transport/link/tls/listen_private",
        ),
        ({"listen_certificate": "ext", "listen_private_key": "robot.key"}, "ext is not a certificate"),
    ],
)
async def test_files_of_a_listener(folder: Path, tls: dict[str, object], fault: str) -> None:
    variables = configured(folder, "listener", tls, listen=[f"tls/localhost:{free_port()}"])
    router = await start_command("core", "--ros2", "zenoh", environment=variables)
    text = await router.finish()
    assert "zenoh cannot listen: " in text
    assert fault in text
    assert "uses the port" not in text
    doctor = await start_command("doctor", "--ros2", "zenoh", environment=variables)
    text = await doctor.finish()
    assert "PROBLEM: " in text
    assert fault in text


async def test_an_unknown_setting(folder: Path) -> None:
    path = folder / "typo.json5"
    path.write_text('{ mode: "router", lissten: {} }')
    router = await start_command(
        "core", "--ros2", "zenoh", environment={"ZENOH_ROUTER_CONFIG_URI": str(path)}
    )
    text = await router.finish()
    assert "is not a zenoh configuration: unknown field `lissten`" in text
    assert "(line 1, column 19)" in text
    assert "Message" not in text


async def test_an_endpoint_that_does_not_answer(folder: Path) -> None:
    port = free_port()
    places = {"listen": [f"tcp/localhost:{free_port()}"], "connect": [f"tls/localhost:{port}"]}
    other = await start_command(
        "core", "--ros2", "zenoh", environment=configured(folder, "dead", TRUSTED, **places)
    )
    try:
        await other.wait_for(f"no zenoh router answers at tls/localhost:{port} yet")
        await other.wait_for("Connection refused")
        await other.wait_for("Only this machine can reach it")
    finally:
        await other.stop(signal.SIGTERM)
    session = {"ZENOH_CONFIG_OVERRIDE": f'connect/endpoints=["tcp/localhost:{port}"]'}
    listing = await start_command("topic", "list", "--ros2", "zenoh", environment=session)
    assert "no zenoh router answers at the configured endpoints" in await listing.finish()
    assert listing.process.returncode == 1

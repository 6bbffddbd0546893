"""The page that explains how to make a device trust this machine, with the certificate to install."""

from __future__ import annotations

import html
from pathlib import Path

AUTHORITY_FILE = "authority.crt"
TRUST_PAGE_FILE = "certificate.html"

_PAGE = """<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8">
    <meta name="viewport" content="width=device-width, initial-scale=1">
    <title>Trust {host}</title>
  </head>
  <body>
    <h1>Trust {host}</h1>
    <p>This robot issues its own certificate. Install it once, and the browser shows the page without a
      warning. The certificate is valid only for this machine and for addresses of local
      networks.</p>
    <p><a href="/{file}">Download the certificate</a></p>
    <h2>Android</h2>
    <p>Open Settings, search for "CA certificate", choose "Install anyway", and select the file.</p>
    <h2>iPhone, iPad</h2>
    <p>Allow the download. Open Settings, "Profile Downloaded", and install it. Then open General, About,
      Certificate Trust Settings, and switch it on.</p>
    <h2>Windows</h2>
    <p>Open the file, "Install Certificate", and choose the store
      "Trusted Root Certification Authorities".</p>
    <h2>macOS</h2>
    <p>Open the file with Keychain Access, and set it to "Always Trust".</p>
    <h2>Linux, ChromeOS, Firefox</h2>
    <p>Open the browser's settings, search for "certificates", and import the file as an authority.</p>
    <p><a href="/">Go to the dashboard</a></p>
  </body>
</html>
"""


def authority_files(authority: Path, host: str) -> dict[str, bytes]:
    """Return the files to serve with the page: the authority's certificate, and how to install it."""
    page = _PAGE.format(host=html.escape(host), file=AUTHORITY_FILE)
    return {AUTHORITY_FILE: authority.read_bytes(), TRUST_PAGE_FILE: page.encode()}

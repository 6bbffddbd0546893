"""A scene as a PNG file: its SVG, drawn by the package `resvg_py` (extra `pictures`)."""

from __future__ import annotations

from typing import Any

from rostether.errors import ConfigError
from rostether.extras import install_command
from rostether.pictures.scene import Scene
from rostether.pictures.svg import svg

# Larger pictures need hundreds of megabytes, and viewers cannot show them well.
MAX_PIXELS = 40_000_000

# Pixels per unit of the scene: sharp on high-resolution screens.
_SCALE = 2


def png(scene: Scene, *, scale: int = _SCALE) -> bytes:
    """Return the picture as a PNG file with `scale` pixels per unit of the scene, or one if it is large.

    Raises ConfigError if the picture is too large, resvg_py is not installed, or the system has no font.
    """
    if scene.width * scene.height * scale * scale > MAX_PIXELS:
        scale = 1
    width, height = scene.width * scale, scene.height * scale
    if width * height > MAX_PIXELS:
        raise ConfigError(
            f"a PNG of {width} x {height} pixels is too large; save as .svg, or show less of the graph"
        )
    resvg = _resvg_package()
    _check_fonts(resvg)
    return bytes(resvg.svg_to_bytes(svg_string=svg(scene), zoom=scale))


def _resvg_package() -> Any:
    try:
        import resvg_py
    except ImportError:
        raise ConfigError(
            f"PNG is not installed; run: {install_command('pictures')}; or save as .svg"
        ) from None
    return resvg_py


def _check_fonts(resvg: Any) -> None:
    # Without a font, resvg leaves out all text without an error.
    blank, letter = Scene(20, 20), Scene(20, 20)
    letter.text(2, 16, "M", 16, (0, 0, 0))
    if resvg.svg_to_bytes(svg_string=svg(blank)) == resvg.svg_to_bytes(svg_string=svg(letter)):
        raise ConfigError(
            "no font for the text of the picture is installed; install one, such as the package "
            "fonts-dejavu-core, or save as .svg"
        )

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Any

import pytest
from PIL import Image, ImageDraw, ImageFilter

from rostether.errors import ConfigError, SensorError
from rostether.platform.sensors.camera import MESSAGE_TYPE, publish_pictures
from rostether.platform.sensors.cascade import CascadeDetector
from rostether.platform.sensors.jpeg import PictureChange, changed_jpeg, draw_test_picture, jpeg_of_yuyv
from rostether.platform.sensors.picture_sources import DrawnTestPictures, PictureFolder
from rostether.platform.sensors.v4l2_camera import V4l2Camera
from unit.platform.datagrams import running
from unit.platform.sensors.shown_sensors import described, shown_sensors
from waiting import until

WHAT = described("CAMERA", MESSAGE_TYPE, rate_hz=50.0)


def picture(color: str = "red") -> bytes:
    """Return a JPEG of 32 x 16 pixels, black in its upper left quarter."""
    image = Image.new("RGB", (32, 16), color)
    image.paste("black", (0, 0, 16, 8))
    output = io.BytesIO()
    image.save(output, "JPEG")
    return output.getvalue()


def is_black(data: bytes, x: int, y: int) -> bool:
    with Image.open(io.BytesIO(data)) as image:
        assert image.format == "JPEG"
        return sum(rgb(image, x, y)) < 60


def rgb(image: Any, x: int, y: int) -> tuple[int, int, int]:
    red, green, blue = image.convert("RGB").getpixel((x, y))
    return red, green, blue


async def test_a_folder_of_pictures_is_read_only_while_a_program_shows_them(tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    source = PictureFolder(folder, PictureChange())
    received: list[Any] = []
    async with shown_sensors() as shown, running(publish_pictures(shown.robot, WHAT, source, shown.report)):
        await shown.has_state(WHAT.id, f"alert {folder}: No such file or directory")
        folder.mkdir()
        (folder / "1.jpg").write_bytes(picture())
        # Never read: no program shows it.
        (folder / "2.jpg").write_bytes(b"none")
        (folder / "3.jpg").write_bytes(picture("lime"))
        (folder / "4.jpg").mkdir()
        await shown.has_state(WHAT.id, "ready")
        viewing = await shown.viewer.subscriber(WHAT.topic, MESSAGE_TYPE, received.append)
        damaged = f"{WHAT.id}: {folder / '2.jpg'} is not a JPEG picture"
        next_step = "plug the camera in, or choose another ~source, such as test; trying again every second"
        await until(lambda: f"{damaged}; {next_step}" in shown.report.texts)
        await until(lambda: picture("lime") in {bytes(each.data) for each in received})
        (folder / "2.jpg").write_bytes(picture("blue"))
        await until(lambda: len({bytes(each.data) for each in received}) == 3)
        await viewing.close()
        await until(lambda: shown.network.snapshot().topics[WHAT.topic].subscribers == ())
    assert bytes(received[0].data) == picture()
    assert [each.header.seq for each in received] == list(range(len(received)))
    assert received[0].format == "jpeg"
    assert received[0].header.stamp.secs > 0


@pytest.mark.parametrize(
    ("change", "black", "size"),
    [
        (PictureChange(vflip=True), (4, 12), (32, 16)),
        (PictureChange(hflip=True), (28, 4), (32, 16)),
        (PictureChange(width=64, height=32, quality=95), (8, 8), (64, 32)),
    ],
)
def test_pictures_are_changed(change: PictureChange, black: tuple[int, int], size: tuple[int, int]) -> None:
    data = changed_jpeg(picture(), change)
    assert is_black(data, *black)
    assert not is_black(data, size[0] - black[0], black[1])
    with Image.open(io.BytesIO(data)) as image:
        assert image.size == size


def test_a_damaged_picture() -> None:
    with pytest.raises(SensorError, match="a picture is damaged"):
        changed_jpeg(picture()[:100], PictureChange(vflip=True))


def test_a_raw_picture_is_encoded() -> None:
    # Two pixels are Y U Y V; the left half is black, the right half red.
    row = b"\x00\x80\x00\x80" * 8 + b"\x4c\x55\x4c\xff" * 8
    data = jpeg_of_yuyv(row * 16, 32, 16, PictureChange(vflip=True))
    assert is_black(data, 4, 8)
    with Image.open(io.BytesIO(data)) as image:
        red, green, blue = rgb(image, 28, 8)
    assert red > 200 > 60 > max(green, blue)
    with pytest.raises(SensorError, match="a picture of 32 x 16 has only 64 bytes"):
        jpeg_of_yuyv(row, 32, 16, PictureChange())


async def test_test_pictures_differ() -> None:
    small = PictureChange(width=64, height=48)
    pictures = DrawnTestPictures(small).pictures(1000.0)
    first, second = [await anext(pictures) for _ in range(2)]
    await pictures.aclose()
    assert first != second
    with Image.open(io.BytesIO(draw_test_picture(1, small))) as image:
        assert image.size == (64, 48)


def drawn_face() -> bytes:
    """Return a JPEG of 320 x 240 pixels with a face around its center."""
    image = Image.new("L", (320, 240), 200)
    draw = ImageDraw.Draw(image)
    draw.ellipse((100, 45, 220, 195), fill=170)
    for eye in (134, 186):
        draw.ellipse((eye - 16, 94, eye + 16, 118), fill=60)
        draw.rectangle((eye - 18, 84, eye + 18, 91), fill=40)
    draw.rectangle((153, 95, 167, 138), fill=215)
    draw.ellipse((146, 130, 174, 144), fill=140)
    draw.ellipse((134, 154, 186, 168), fill=80)
    output = io.BytesIO()
    image.filter(ImageFilter.GaussianBlur(4)).save(output, "JPEG")
    return output.getvalue()


async def test_faces_are_found_and_drawn(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cv2")
    (tmp_path / "1.jpg").write_bytes(drawn_face())
    (tmp_path / "2.jpg").write_bytes(picture())
    source = PictureFolder(tmp_path, PictureChange())
    detector = CascadeDetector(Path("haarcascade_frontalface_default.xml"))
    pictures: dict[int, Any] = {}
    found: dict[int, Any] = {}

    def show(message: Any) -> None:
        pictures[message.header.seq] = bytes(message.data)

    def count(message: Any) -> None:
        found[message.header.seq] = message

    async with (
        shown_sensors() as shown,
        running(publish_pictures(shown.robot, WHAT, source, shown.report, detector)),
    ):
        await shown.viewer.subscriber(f"{WHAT.topic}/detections", "sensing_platform/Detections", count)
        await until(lambda: found)
        await shown.viewer.subscriber(WHAT.topic, MESSAGE_TYPE, show)
        await until(lambda: any(each in found and found[each].regions for each in pictures))
        await until(lambda: any(each in found and not found[each].regions for each in pictures))
    with_face = next(each for each in pictures if each in found and found[each].regions)
    without = next(each for each in pictures if each in found and not found[each].regions)
    (face,) = found[with_face].regions
    assert found[with_face].classifier == "haarcascade_frontalface_default"
    assert face.x_offset < 134 < 186 < face.x_offset + face.width
    with Image.open(io.BytesIO(pictures[with_face])) as image:
        red, green, blue = rgb(image, face.x_offset + face.width // 2, face.y_offset)
    assert green > 150 > max(red, blue)
    assert pictures[without] == picture()
    with pytest.raises(SensorError, match="damaged"):
        detector.detect(b"none")
    with pytest.raises(ConfigError, match=r"nothing\.xml is not a cascade file of OpenCV; some are in"):
        CascadeDetector(tmp_path / "nothing.xml")
    assert capfd.readouterr().err == ""


def test_the_opencv_of_a_linux_distribution(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cv2 = pytest.importorskip("cv2")
    file = Path(cv2.data.haarcascades, "haarcascade_eye.xml")
    monkeypatch.delattr(cv2, "data")
    assert CascadeDetector(file).name == "haarcascade_eye"
    with pytest.raises(ConfigError, match="some are in /usr/share/opencv4/haarcascades, such as"):
        CascadeDetector(tmp_path / "nothing.xml")


async def test_what_is_not_a_camera(tmp_path: Path) -> None:
    pytest.importorskip("linuxpy")
    missing = V4l2Camera(tmp_path / "video0", PictureChange())
    with pytest.raises(FileNotFoundError):
        missing.check()
    with pytest.raises(FileNotFoundError):
        await anext(missing.pictures(10.0))
    with pytest.raises(SensorError, match=r"^/dev/null: "):
        await anext(V4l2Camera(Path("/dev/null"), PictureChange()).pictures(10.0))


@pytest.mark.parametrize("package", ["PIL", "linuxpy.video"])
def test_a_package_that_is_missing(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    pytest.importorskip("linuxpy")
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ConfigError, match=r"run: .*rostether\[camera\]"):
        V4l2Camera(Path("/dev/video0"), PictureChange())

"""A simulated board in the browser: its pins and its environment."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from interop.ros1_peers import free_port
from web.browser import Browser
from web.robot import end, run_rostether, wait_for_page

pytestmark = [pytest.mark.simavr, pytest.mark.asyncio(loop_scope="session")]

SKETCH = """
void setup() {
  Serial.begin(57600);
  pinMode(13, OUTPUT);
  pinMode(7, INPUT_PULLUP);
}

void loop() {
  digitalWrite(13, digitalRead(7) == LOW);
  analogWrite(3, analogRead(0) / 4);
}
"""


async def test_pins_are_shown_and_inputs_are_changed(tmp_path: Path, browser: Browser) -> None:
    sketch = tmp_path / "button" / "button.ino"
    sketch.parent.mkdir()
    sketch.write_text(SKETCH)
    address = f"127.0.0.1:{free_port()}"
    master = f"http://127.0.0.1:{free_port()}"
    process = await run_rostether(tmp_path, master, "serve", f"sim:{sketch}", "--dashboard", address)
    try:
        await wait_for_page(f"http://{address}/", process)
        page = await browser.do("open", url=f"http://{address}/#/simulation", width=390)
        await browser.wait_for(page, f"{_level('D13')} === '0' && {_level('D7')} === '1'")
        # A button connects its pin to ground.
        await browser.do("click", page=page, selector="[data-pin=D7]")
        await browser.wait_for(page, f"{_level('D13')} === '1'")
        await browser.do("click", page=page, selector="[data-pin=D7]")
        await browser.wait_for(page, f"{_level('D13')} === '0'")
        # Two taps that are faster than the updates of the board's state.
        tap = "pin.dispatchEvent(new MouseEvent('click', { bubbles: true }))"
        twice = f"(pin => void [{tap}, {tap}])(document.querySelector('[data-pin=D7]'))"
        await browser.do("evaluate", page=page, script=twice)
        # By keyboard.
        press = "new KeyboardEvent('keydown', { key: 'Enter', bubbles: true })"
        focus = "document.querySelector('[data-pin=D7]').focus()"
        enter = f"void ({focus}, document.activeElement.dispatchEvent({press}))"
        await browser.do("evaluate", page=page, script=enter)
        await browser.wait_for(page, f"{_level('D13')} === '1'")
        await browser.do("click", page=page, selector="[data-pin=D7]")
        await browser.wait_for(page, f"{_level('D13')} === '0'")
        # On touch screens, pins are also buttons.
        phone = await browser.do("open", url=f"http://{address}/#/simulation", width=390, touch=True)
        button = "button[data-pin=D7]"
        await browser.wait_for(phone, f"document.querySelector('{button}')?.offsetHeight >= 44")
        await browser.do("click", page=phone, selector=button)
        await browser.wait_for(page, f"{_level('D13')} === '1'")
        await browser.do("click", page=phone, selector=button)
        await browser.wait_for(page, f"{_level('D13')} === '0'")
        slider = "document.querySelector('[aria-label=\"Voltage at A0\"]')"
        slide = f"{slider}.value = 2.5; void {slider}.dispatchEvent(new Event('input', {{ bubbles: true }}))"
        await browser.do("evaluate", page=page, script=slide)
        await browser.wait_for(page, f"Math.abs({_level('D3')} - 0.5) < 0.02")
        assert (await browser.do("seen", page=page))["errors"] == []
    finally:
        await end(process, signal.SIGINT)


def _level(pin: str) -> str:
    return f"document.querySelector('[data-pin={pin}]')?.dataset.level"

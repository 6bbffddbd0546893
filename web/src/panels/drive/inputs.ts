// Keys and gamepads as a stick.

import { type Stick, withDeadZone } from "./commands.ts";
import type { Driver } from "./driver.ts";

const KEYS: Readonly<Record<string, Stick>> = {
  ArrowUp: { x: 0, y: 1 },
  KeyW: { x: 0, y: 1 },
  ArrowDown: { x: 0, y: -1 },
  KeyS: { x: 0, y: -1 },
  ArrowLeft: { x: -1, y: 0 },
  KeyA: { x: -1, y: 0 },
  ArrowRight: { x: 1, y: 0 },
  KeyD: { x: 1, y: 0 },
};

/** Whether an element uses a key: a slider, which keeps the focus after it is moved, uses only the arrows. */
function uses(element: HTMLElement, key: string): boolean {
  return element.matches("input[type=range]")
    ? key.startsWith("Arrow")
    : element.matches("input, select, textarea");
}

/** Drives with W A S D and the arrow keys, and stops with space, until the returned function is called. */
export function followKeys(driver: Driver): () => void {
  const held = new Set<string>();
  const update = () => {
    let [x, y] = [0, 0];
    for (const key of held) {
      x += KEYS[key]?.x ?? 0;
      y += KEYS[key]?.y ?? 0;
    }
    if (x === 0 && y === 0) driver.release();
    else {
      const length = Math.hypot(x, y);
      driver.hold({ x: x / length, y: y / length });
    }
  };
  const down = (event: KeyboardEvent) => {
    const isForField = event.target instanceof HTMLElement && uses(event.target, event.code);
    if (isForField || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.code === "Space") {
      held.clear();
      driver.stop();
      event.preventDefault();
    } else if (event.code in KEYS) {
      event.preventDefault();
      if (event.repeat) return;
      held.add(event.code);
      update();
    }
  };
  const up = (event: KeyboardEvent) => {
    if (held.delete(event.code)) update();
  };
  const clear = () => {
    if (held.size === 0) return;
    held.clear();
    update();
  };
  addEventListener("keydown", down);
  addEventListener("keyup", up);
  addEventListener("blur", clear);
  return () => {
    removeEventListener("keydown", down);
    removeEventListener("keyup", up);
    removeEventListener("blur", clear);
    clear();
  };
}

/** Drives with the left stick of the first gamepad, until the returned function is called. */
export function followGamepad(driver: Driver): () => void {
  let isHeld = false;
  const timer = setInterval(() => {
    const pad = navigator.getGamepads().find((each) => each !== null);
    const stick = { x: pad?.axes[0] ?? 0, y: -(pad?.axes[1] ?? 0) };
    const { x, y } = withDeadZone(stick);
    if (x !== 0 || y !== 0) {
      isHeld = true;
      driver.hold(stick);
    } else if (isHeld) {
      isHeld = false;
      driver.release();
    }
  }, 40);
  return () => {
    clearInterval(timer);
    if (isHeld) driver.release();
  };
}

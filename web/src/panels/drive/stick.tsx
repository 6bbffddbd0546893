// A stick for a thumb or a mouse.
import { useEffect, useRef } from "preact/hooks";
import { formatNumber } from "../../shell/format.ts";
import { texts } from "../../texts.ts";
import { commandOf, type Stick } from "./commands.ts";
import type { Driver } from "./driver.ts";

export function StickPad({ driver }: { driver: Driver }) {
  const pad = useRef<HTMLDivElement>(null);
  const knob = useRef<HTMLDivElement>(null);
  const { x, y } = driver.stick.value;
  useEffect(() => {
    const element = knob.current as HTMLDivElement;
    element.style.left = `${50 + x * 40}%`;
    element.style.top = `${50 - y * 40}%`;
  });
  const positionOf = (event: PointerEvent): Stick => {
    const { left, top, width, height } = (pad.current as HTMLDivElement).getBoundingClientRect();
    const right = (event.clientX - left - width / 2) / (width * 0.4);
    const forward = (top + height / 2 - event.clientY) / (height * 0.4);
    const length = Math.max(1, Math.hypot(right, forward));
    return { x: right / length, y: forward / length };
  };
  return (
    <div class="stick">
      <div class="stick-value number">{valueText(driver)}</div>
      <div
        class="stick-pad"
        ref={pad}
        role="application"
        aria-label={texts.drive.stick}
        onPointerDown={(event) => {
          event.preventDefault();
          event.currentTarget.setPointerCapture(event.pointerId);
          driver.hold(positionOf(event));
        }}
        onPointerMove={(event) => {
          if (event.currentTarget.hasPointerCapture(event.pointerId)) driver.hold(positionOf(event));
        }}
        onPointerUp={() => driver.release()}
        onPointerCancel={() => driver.release()}
        onLostPointerCapture={() => driver.release()}
      >
        <div class="stick-knob" ref={knob} />
      </div>
    </div>
  );
}

function valueText(driver: Driver): string {
  const command = commandOf(driver.commandType, driver.stick.value, driver.limits) as {
    dir?: number;
    speed?: number;
    linear?: { x: number };
    angular?: { z: number };
    twist?: { linear: { x: number }; angular: { z: number } };
  };
  if (command.dir !== undefined)
    return texts.drive.direction(formatNumber(command.dir, 3), formatNumber(command.speed ?? 0, 2));
  const twist = command.twist ?? command;
  return texts.drive.twist((twist.linear?.x ?? 0).toFixed(2), (twist.angular?.z ?? 0).toFixed(2));
}

// The place of the stop button in the header: always visible, on every page.
import type { Robot } from "../store/robot.ts";

export function StopButton(_: { robot: Robot }) {
  return null;
}

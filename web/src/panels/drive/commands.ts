// A stick's position as a command of each type that robots are driven with.
import type { StructNode } from "../../wire/schema.ts";
import { stampNow } from "../../wire/stamp.ts";
import { hasFields, type SettingCheck } from "../setting_checks.ts";

/** The stick: x to the right and y forward, within a circle of 1. */
export interface Stick {
  readonly x: number;
  readonly y: number;
}
export interface Limits {
  /** Meters a second. For ArduinoControl: the fraction of the full speed. */
  readonly linear: number;
  /** Radians a second. */
  readonly angular: number;
}

export const CENTER: Stick = { x: 0, y: 0 };
export const DEFAULT_LIMITS: Limits = { linear: 0.3, angular: 1 };
/** The ends of the sliders. */
export const LARGEST_LIMITS: Limits = { linear: 2, angular: 4 };
/** A page's address must not allow more speed than the sliders, or invert the stick. */
export const areLimits: SettingCheck = hasFields({
  linear: (value) => isBetween(value, LARGEST_LIMITS.linear),
  angular: (value) => isBetween(value, LARGEST_LIMITS.angular),
});
/** The usual dead zone of joysticks, so that a resting thumb does not move the robot. */
const DEAD_ZONE = 0.1;
const DEGREES = 180 / Math.PI;

export const DRIVE_TYPES: readonly string[] = [
  "geometry_msgs/Twist",
  "geometry_msgs/TwistStamped",
  "arduino_control/ArduinoControl",
];

/** The position with a dead zone of 0.1, rescaled so that it begins at 0, and at most 1 long. */
export function withDeadZone({ x, y }: Stick): Stick {
  const length = Math.hypot(x, y);
  if (!(length > DEAD_ZONE)) return CENTER;
  const scaled = (Math.min(length, 1) - DEAD_ZONE) / (1 - DEAD_ZONE);
  return { x: (x / length) * scaled, y: (y / length) * scaled };
}

/** The command of a type of DRIVE_TYPES. REP 103: x forward, a positive turn is to the left. */
export function commandOf(type: StructNode, stick: Stick, limits: Limits): Record<string, unknown> {
  const { x, y } = withDeadZone(stick);
  if (type.name === "arduino_control/ArduinoControl") {
    const isCenter = x === 0 && y === 0;
    // Degrees to the right of forward, and the fraction of the full speed.
    return {
      dir: isCenter ? 0 : Math.atan2(x, y) * DEGREES,
      speed: Math.hypot(x, y) * Math.min(limits.linear, 1),
    };
  }
  const twist = { linear: { x: y * limits.linear }, angular: { z: -x * limits.angular || 0 } };
  if (type.name === "geometry_msgs/Twist") return twist;
  return { header: { stamp: stampNow(), frame_id: "base_link" }, twist };
}

function isBetween(value: unknown, largest: number): boolean {
  return typeof value === "number" && value > 0 && value <= largest;
}

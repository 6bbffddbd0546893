// The contract between a sensor of this device and the panel that switches it on.
import type { PhoneType } from "./definitions.ts";

export type SensorId = "imu" | "gps" | "camera" | "battery";
export type Problem =
  | "denied"
  | "missing"
  | "busy"
  | "unavailable"
  | "insecure"
  /** An error of the browser, with its text. */
  | { text: string };

/** Why a sensor cannot be used. */
export class SensorError extends Error {
  readonly problem: Problem;

  constructor(problem: Problem) {
    super(typeof problem === "string" ? problem : problem.text);
    this.problem = problem;
  }
}

export interface SensorSettings {
  /** The limit of messages a second; 0 means no limit. */
  hertz: number;
  /** Pixels, of the camera. */
  width: number;
  height: number;
  /** Whether the front camera is used. */
  isFront: boolean;
}

export interface SensorOutput {
  readonly settings: SensorSettings;
  /** Whether a message would be sent soon; otherwise, a sensor with large messages makes none. */
  hasRoom(): boolean;
  /** Publishes the fields other than the header, measured at a time of the page in milliseconds. */
  publish(fields: Record<string, unknown>, measuredMs: number): void;
  /** Reports an error after the start; the sensor then ends. */
  fail(problem: Problem): void;
}

export interface Sensor {
  id: SensorId;
  type: PhoneType;
  /** The topic below the phone's name. */
  topic: string;
  /** Starts to publish; resolves with a function that ends it. Rejects with SensorError. */
  start(output: SensorOutput): Promise<() => void>;
}

/** Lets a message pass if the last one is old enough; it may be early by a tenth of the period, as events are irregular. */
export function rateLimiter(hertz: number): (nowMs: number) => boolean {
  let nextMs = Number.NEGATIVE_INFINITY;
  const periodMs = hertz > 0 ? 1000 / hertz : 0;
  return (nowMs) => {
    if (nowMs < nextMs - periodMs / 10) return false;
    nextMs = Math.max(nextMs, nowMs - periodMs) + periodMs;
    return true;
  };
}

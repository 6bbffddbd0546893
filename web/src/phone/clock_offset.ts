// The robot's clock, seen from this page: the server answers with its time, as in NTP.
import type { Stamp } from "../wire/stamp.ts";

// Old answers are dropped, so that the offset follows a clock that drifts or is set.
const KEPT = 8;

interface Sample {
  offsetMs: number;
  roundTripMs: number;
}

/** This page's clock in milliseconds since 1970; it never jumps. */
export function pageTimeMs(sinceOriginMs = performance.now()): number {
  return performance.timeOrigin + sinceOriginMs;
}

export class ClockOffset {
  private readonly samples: Sample[] = [];

  /** Notes an answer: the page's time at the request and at the answer, and the robot's time in it. */
  add(askedMs: number, answeredMs: number, robot: Stamp): void {
    const robotMs = robot.sec * 1000 + robot.nsec / 1e6;
    const roundTripMs = answeredMs - askedMs;
    this.samples.push({ offsetMs: robotMs - askedMs - roundTripMs / 2, roundTripMs });
    if (this.samples.length > KEPT) this.samples.shift();
  }

  /** The offset of the fastest answer, which is the most exact. Undefined without an answer. */
  get best(): Sample | undefined {
    return this.samples.reduce<Sample | undefined>(
      (best, each) => (best && best.roundTripMs <= each.roundTripMs ? best : each),
      undefined,
    );
  }

  /** The robot's time at a time of the page; undefined without an answer. */
  stamp(pageMs: number): Stamp | undefined {
    const { best } = this;
    if (!best) return undefined;
    const ms = pageMs + best.offsetMs;
    const sec = Math.floor(ms / 1000);
    return { sec, nsec: Math.min(999_999_999, Math.round((ms - sec * 1000) * 1e6)) };
  }

  clear(): void {
    this.samples.length = 0;
  }
}

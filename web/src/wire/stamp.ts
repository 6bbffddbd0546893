// Times and durations of messages.

/** Seconds and nanoseconds; the nanoseconds are positive even below zero: -0.5 s is -1 s and 500,000,000 ns. */
export interface Stamp {
  sec: number;
  nsec: number;
}

/** This device's time. */
export function stampNow(): Stamp {
  const ms = Date.now();
  return { sec: Math.floor(ms / 1000), nsec: (ms % 1000) * 1_000_000 };
}

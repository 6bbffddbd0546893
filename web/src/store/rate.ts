// The rate of a topic: messages and bytes a second over the last arrivals, and when its values are stale.

const KEPT = 64;
const WINDOW_MS = 5000;
// Without a known period, a value is stale after this.
const FIRST_STALE_MS = 3000;
const MIN_STALE_MS = 500;
const MAX_STALE_MS = 60_000;
const STALE_PERIODS = 3;

export class RateMeter {
  private readonly times = new Float64Array(KEPT);
  private readonly sizes = new Float64Array(KEPT);
  private count = 0;

  add(nowMs: number, bytes: number): void {
    const index = this.count++ % KEPT;
    this.times[index] = nowMs;
    this.sizes[index] = bytes;
  }

  get lastMs(): number {
    return this.count === 0 ? Number.NEGATIVE_INFINITY : this.times[(this.count - 1) % KEPT]!;
  }

  /** Messages a second, 0 when there are fewer than two in the window. */
  hertz(nowMs: number): number {
    const { messages, spanMs } = this.window(nowMs);
    return messages > 1 && spanMs > 0 ? ((messages - 1) * 1000) / spanMs : 0;
  }

  bytesPerSecond(nowMs: number): number {
    const { messages, bytes } = this.window(nowMs);
    return messages > 0 ? (bytes / messages) * this.hertz(nowMs) : 0;
  }

  /** Whether more than three periods passed since the last message. */
  isStale(nowMs: number): boolean {
    return nowMs - this.lastMs > this.staleAfterMs();
  }

  /** How long a value counts, in milliseconds. */
  staleAfterMs(): number {
    const kept = Math.min(this.count, KEPT);
    if (kept < 3) return FIRST_STALE_MS;
    const oldest = this.times[(this.count - kept) % KEPT]!;
    const periodMs = (this.lastMs - oldest) / (kept - 1);
    return Math.min(MAX_STALE_MS, Math.max(MIN_STALE_MS, STALE_PERIODS * periodMs));
  }

  clear(): void {
    this.count = 0;
  }

  private window(nowMs: number): { messages: number; bytes: number; spanMs: number } {
    let messages = 0;
    let bytes = 0;
    let oldest = nowMs;
    for (let back = 1; back <= Math.min(this.count, KEPT); back++) {
      const index = (this.count - back) % KEPT;
      if (nowMs - this.times[index]! > WINDOW_MS) break;
      oldest = this.times[index]!;
      messages++;
      bytes += this.sizes[index]!;
    }
    return { messages, bytes, spanMs: this.lastMs - oldest };
  }
}

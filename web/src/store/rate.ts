// The rate of a topic: messages and bytes a second over the last seconds, and when its values are stale.

const KEPT = 64;
// The last seconds are counted in parts, so that messages that waited for a busy page do not look like a high rate.
const PART_MS = 100;
const PARTS = 50;
// Two latched messages that arrive together do not give a rate.
const MIN_SPAN_MS = 500;
// Without a known period, a value is stale after this.
const FIRST_STALE_MS = 3000;
const MIN_STALE_MS = 500;
const MAX_STALE_MS = 60_000;
const STALE_PERIODS = 3;

export class RateMeter {
  private readonly times = new Float64Array(KEPT);
  private count = 0;
  private startMs = Number.NEGATIVE_INFINITY;
  /** The parts of the last seconds: their numbers, messages and bytes, and the arrival time of the first message. */
  private readonly numbers = new Float64Array(PARTS).fill(Number.NEGATIVE_INFINITY);
  private readonly messages = new Float64Array(PARTS);
  private readonly sizes = new Float64Array(PARTS);
  private readonly firsts = new Float64Array(PARTS);
  /** The arrival time of the last message. */
  lastMs = Number.NEGATIVE_INFINITY;

  /** Starts to measure; an earlier pause does not count. */
  start(nowMs: number): void {
    this.count = 0;
    this.startMs = nowMs;
    this.numbers.fill(Number.NEGATIVE_INFINITY);
  }

  add(nowMs: number, bytes: number): void {
    this.times[this.count++ % KEPT] = nowMs;
    this.lastMs = nowMs;
    const number = Math.floor(nowMs / PART_MS);
    const part = number % PARTS;
    if (this.numbers[part] !== number) {
      this.numbers[part] = number;
      this.messages[part] = this.sizes[part] = 0;
      this.firsts[part] = nowMs;
    }
    this.messages[part]!++;
    this.sizes[part]! += bytes;
  }

  /** Messages a second, 0 when there are fewer than two in the last seconds. */
  hertz(nowMs: number): number {
    const { messages, firstMs } = this.window(nowMs);
    if (messages < 2) return 0;
    const periods = ((messages - 1) * 1000) / Math.max(this.lastMs - firstMs, MIN_SPAN_MS);
    // The first messages may have waited since the page subscribed.
    const hasBegun = messages === this.count && Number.isFinite(this.startMs);
    return hasBegun ? Math.min(periods, (messages * 1000) / (this.lastMs - this.startMs)) : periods;
  }

  bytesPerSecond(nowMs: number): number {
    const { messages, bytes } = this.window(nowMs);
    return messages > 0 ? (bytes / messages) * this.hertz(nowMs) : 0;
  }

  /** Whether more than three periods passed since the last message. */
  isStale(nowMs: number): boolean {
    return nowMs - this.lastMs > this.staleAfterMs();
  }

  /** The age, in milliseconds, from which a value is stale. */
  staleAfterMs(): number {
    const kept = Math.min(this.count, KEPT);
    if (kept < 3) return FIRST_STALE_MS;
    const oldest = this.times[(this.count - kept) % KEPT]!;
    const periodMs = (this.lastMs - oldest) / (kept - 1);
    return Math.min(MAX_STALE_MS, Math.max(MIN_STALE_MS, STALE_PERIODS * periodMs));
  }

  clear(): void {
    this.start(Number.NEGATIVE_INFINITY);
    this.lastMs = Number.NEGATIVE_INFINITY;
  }

  private window(nowMs: number): { messages: number; bytes: number; firstMs: number } {
    const oldest = Math.floor(nowMs / PART_MS) - PARTS;
    let messages = 0;
    let bytes = 0;
    let firstMs = Number.POSITIVE_INFINITY;
    for (let part = 0; part < PARTS; part++) {
      if (this.numbers[part]! <= oldest) continue;
      messages += this.messages[part]!;
      bytes += this.sizes[part]!;
      firstMs = Math.min(firstMs, this.firsts[part]!);
    }
    return { messages, bytes, firstMs };
  }
}

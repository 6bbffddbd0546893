// The last five minutes of one number, in typed arrays. A gap in the data is a NaN.

/** The history of a plot, in seconds. */
export const KEPT_S = 300;
const FIRST_POINTS = 1024;
// Five minutes at 1.7 kHz; faster series keep less.
const MAX_POINTS = 1 << 19;
// A clock that goes back by more was set: earlier values belong to another time.
const SET_BACK_S = 1;
// A pause longer than usual by this factor is a gap, for series of 2 Hz or faster.
const GAP_PERIODS = 4;
const MIN_GAP_S = 1;
const REGULAR_PERIOD_S = 0.5;

export class SeriesBuffer {
  private times = new Float64Array(FIRST_POINTS);
  private values = new Float64Array(FIRST_POINTS);
  private head = 0;
  private count = 0;
  private meanPeriodS = Number.NaN;
  private wasInterrupted = false;

  get length(): number {
    return this.count;
  }

  time(index: number): number {
    return this.times[(this.head + index) % this.times.length]!;
  }

  value(index: number): number {
    return this.values[(this.head + index) % this.values.length]!;
  }

  get lastTime(): number {
    return this.count > 0 ? this.time(this.count - 1) : Number.NEGATIVE_INFINITY;
  }

  get lastValue(): number {
    return this.count > 0 ? this.value(this.count - 1) : Number.NaN;
  }

  /** Adds a value; times are seconds and do not go back, except when the clock was set. */
  push(timeS: number, value: number): void {
    let time = timeS;
    if (this.count > 0) {
      const passed = time - this.lastTime;
      if (passed < -SET_BACK_S) this.clear();
      else if (passed < 0) time = this.lastTime;
      else if (this.isGap(passed)) this.append(this.lastTime, Number.NaN);
      if (passed >= 0 && !this.wasInterrupted) {
        this.meanPeriodS = Number.isNaN(this.meanPeriodS) ? passed : this.meanPeriodS * 0.9 + passed * 0.1;
      }
    }
    this.wasInterrupted = false;
    this.append(time, value);
    while (this.count > 0 && this.time(0) < time - KEPT_S) this.dropOldest();
  }

  /** Nothing was received for a while: the line breaks before the next value. */
  interrupt(): void {
    this.wasInterrupted = true;
  }

  clear(): void {
    this.head = 0;
    this.count = 0;
    this.meanPeriodS = Number.NaN;
  }

  /** The index of the first value at or after a time. */
  indexAt(timeS: number): number {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) < timeS) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  private isGap(passedS: number): boolean {
    const usual = this.meanPeriodS;
    if (this.wasInterrupted) return !(passedS < 2 * usual);
    return usual < REGULAR_PERIOD_S && passedS > Math.max(MIN_GAP_S, GAP_PERIODS * usual);
  }

  private append(time: number, value: number): void {
    if (this.count === this.times.length) {
      if (this.count < MAX_POINTS) this.grow();
      else this.dropOldest();
    }
    const index = (this.head + this.count) % this.times.length;
    this.times[index] = time;
    this.values[index] = value;
    this.count++;
  }

  private dropOldest(): void {
    this.head = (this.head + 1) % this.times.length;
    this.count--;
  }

  private grow(): void {
    const size = this.times.length;
    this.times = straightened(this.times, this.head, size * 2);
    this.values = straightened(this.values, this.head, size * 2);
    this.head = 0;
  }
}

function straightened(ring: Float64Array, head: number, size: number): Float64Array<ArrayBuffer> {
  const larger = new Float64Array(size);
  larger.set(ring.subarray(head));
  larger.set(ring.subarray(0, head), ring.length - head);
  return larger;
}

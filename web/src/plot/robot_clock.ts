// The robot's current time, from the times of its messages: the right edge of a running plot.

// A larger difference is not a delay of the line: one of the two clocks was set.
const MAX_DELAY_S = 2;
// The estimate follows a drifting clock slowly, because a message may be late but never early.
const SHARE_OF_A_MESSAGE = 0.0005;

export class RobotClock {
  private offsetS = Number.NaN;
  private readonly simulatedNs: () => bigint | undefined;

  /** `simulatedNs` is the simulated time, undefined while there is none. It may run fast, slowly or not at all. */
  constructor(simulatedNs: () => bigint | undefined) {
    this.simulatedNs = simulatedNs;
  }

  /** Records a message's time on the robot and its arrival time. */
  note(timeS: number, receivedMs: number): void {
    const offset = timeS - receivedMs / 1000;
    if (!(Math.abs(offset - this.offsetS) < MAX_DELAY_S)) this.offsetS = offset;
    else if (offset > this.offsetS) this.offsetS = offset;
    else this.offsetS += (offset - this.offsetS) * SHARE_OF_A_MESSAGE;
  }

  /** The robot's time in seconds since 1970; this machine's time until the first message arrives. */
  nowS(): number {
    const simulatedNs = this.simulatedNs();
    if (simulatedNs !== undefined) return Number(simulatedNs) / 1e9;
    return Number.isNaN(this.offsetS) ? Date.now() / 1000 : performance.now() / 1000 + this.offsetS;
  }
}

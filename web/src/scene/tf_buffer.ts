// The tree of frames with 10 s of history, like tf2's buffer (REP 105, tf2 BufferCore).
import { compose, IDENTITY, interpolate, invert, normalized, type Transform } from "./rigid.ts";

/** tf2 keeps 10 s too. */
const HISTORY_S = 10;
/** Broadcasts at 100 Hz fill a history; faster ones keep a shorter one. */
const MAX_SAMPLES = 1000;
/** How much of a history is cut at a time, in samples and in seconds. */
const CUT_SAMPLES = 64;
const CUT_S = 1;
/** tf2 accepts quaternions whose squared length differs from 1 by less. */
const NORM_TOLERANCE = 10e-3;
/** More frames than any robot has; a flood of new names must not fill the memory. */
export const MAX_FRAMES = 4096;

interface Sample {
  readonly timeS: number;
  readonly transform: Transform;
}

export interface Edge {
  readonly child: string;
  parent: string;
  isStatic: boolean;
  /** Sorted by time; one for a static transform. */
  samples: Sample[];
  /** When the newest transform arrived, on the page's clock. */
  receivedMs: number;
}

export interface Found {
  readonly transform: Transform;
  /** The time of its data; Infinity if all transforms are static. */
  readonly timeS: number;
}

/** ROS 1 frames may have a leading slash, which tf2 removes too. */
export function frameName(name: string): string {
  return name.startsWith("/") ? name.slice(1) : name;
}

export class TfBuffer {
  readonly edges = new Map<string, Edge>();
  /** Why the newest transform of a frame was ignored, by frame. */
  private readonly ignored = new Map<string, string>();
  /** Grows with each new frame or parent, so that views know when the tree has changed. */
  treeVersion = 0;

  /** Stores the pose of `child` in `parent`. Like tf2, it ignores invalid transforms. */
  insert(
    parent: string,
    child: string,
    timeS: number,
    transform: Transform,
    isStatic: boolean,
    receivedMs: number,
  ): void {
    const name = frameName(child);
    const above = frameName(parent);
    if (name === "" || above === "" || name === above) return;
    const invalid = invalidPart(transform);
    if (invalid !== undefined) {
      if (this.ignored.size < MAX_FRAMES) this.ignored.set(name, `ROS ignores the frame ${name}: ${invalid}`);
      return;
    }
    this.ignored.delete(name);
    const sample = { timeS, transform: { ...transform, rotation: normalized(transform.rotation) } };
    let edge = this.edges.get(name);
    if (edge === undefined) {
      if (this.edges.size >= MAX_FRAMES) return;
      edge = { child: name, parent: above, isStatic, samples: [], receivedMs };
      this.edges.set(name, edge);
      this.treeVersion++;
    } else if (edge.parent !== above) {
      edge.parent = above;
      edge.samples = [];
      this.treeVersion++;
    }
    edge.isStatic = isStatic;
    edge.receivedMs = receivedMs;
    if (isStatic) edge.samples = [sample];
    else insertSample(edge, sample);
  }

  /** Clears the transforms that are not static, like tf2: the clock went back, so they belong to an earlier run. */
  clearHistory(): void {
    for (const edge of this.edges.values()) if (!edge.isStatic) edge.samples = [];
  }

  /** Why frames are missing: ignored transforms, and loops of parents. */
  problems(): string[] {
    const loops = new Set<string>();
    for (const frame of this.edges.keys()) {
      const chain = this.chain(frame);
      const above = this.edges.get(chain.at(-1)!)?.parent;
      if (above !== undefined) loops.add(chain.slice(chain.indexOf(above)).sort().join(", "));
    }
    return [...this.ignored.values(), ...[...loops].map((each) => `These frames form a loop: ${each}.`)];
  }

  /** All frames, including those that have no parent. */
  frames(): string[] {
    const names = new Set<string>();
    for (const edge of this.edges.values()) {
      names.add(edge.parent);
      names.add(edge.child);
    }
    return [...names].sort();
  }

  /** The root of the tree that contains the frame. */
  root(frame: string): string {
    return this.chain(frameName(frame)).at(-1) ?? frame;
  }

  /**
   * The pose of `source` in `target`.
   *
   * @param atS the time in seconds; null means the newest time that all transforms between the two have.
   * @returns the transform, or a sentence with the reason.
   */
  lookup(target: string, source: string, atS: number | null = null): Found | string {
    const to = frameName(target);
    const from = frameName(source);
    if (to === from) return { transform: IDENTITY, timeS: Number.POSITIVE_INFINITY };
    const up = this.chain(from);
    const down = this.chain(to);
    const common = up.find((frame) => down.includes(frame));
    if (common === undefined) {
      const missing = [from, to].find((frame) => !this.knows(frame));
      if (missing !== undefined)
        return this.ignored.get(missing) ?? `Nothing publishes the frame ${missing} on /tf.`;
      return `The frames ${from} and ${to} are not connected by /tf.`;
    }
    const rising = up.slice(0, up.indexOf(common));
    const falling = down.slice(0, down.indexOf(common));
    const timeS = atS ?? this.newestCommonS([...rising, ...falling]);
    const inCommon = (frames: string[]): Transform | string => {
      let transform = IDENTITY;
      for (const frame of frames) {
        const edge = this.edges.get(frame) as Edge;
        const step = sampleAt(edge, timeS);
        if (typeof step === "string") return step;
        transform = compose(step, transform);
      }
      return transform;
    };
    const a = inCommon(rising);
    if (typeof a === "string") return a;
    const b = inCommon(falling);
    if (typeof b === "string") return b;
    return { transform: compose(invert(b), a), timeS };
  }

  private knows(frame: string): boolean {
    if (this.edges.has(frame)) return true;
    for (const edge of this.edges.values()) if (edge.parent === frame) return true;
    return false;
  }

  private newestCommonS(frames: string[]): number {
    let newestS = Number.POSITIVE_INFINITY;
    for (const frame of frames) {
      const edge = this.edges.get(frame) as Edge;
      if (!edge.isStatic) newestS = Math.min(newestS, edge.samples.at(-1)?.timeS ?? newestS);
    }
    return newestS;
  }

  /** Returns the frame and all frames above it, up to the first one that is repeated. */
  private chain(frame: string): string[] {
    const names = [frame];
    const seen = new Set(names);
    for (let edge = this.edges.get(frame); edge !== undefined; edge = this.edges.get(edge.parent)) {
      if (seen.has(edge.parent)) break;
      seen.add(edge.parent);
      names.push(edge.parent);
    }
    return names;
  }
}

/** The reason why tf2 does not accept a transform, as a sentence. */
function invalidPart({ translation, rotation }: Transform): string | undefined {
  const shown = (numbers: readonly number[]) =>
    `(${numbers.map((each) => Number(each.toPrecision(4))).join(", ")})`;
  if (!translation.every(Number.isFinite)) return `its translation ${shown(translation)} is not finite.`;
  const norm = rotation.reduce((sum, each) => sum + each * each, 0);
  if (Math.abs(norm - 1) < NORM_TOLERANCE) return undefined;
  return `its rotation ${shown(rotation)} is not a unit quaternion.`;
}

function insertSample(edge: Edge, sample: Sample): void {
  const { samples } = edge;
  const newest = samples.at(-1);
  if (newest === undefined || sample.timeS > newest.timeS) {
    samples.push(sample);
    const oldestS = sample.timeS - HISTORY_S;
    // Cut in blocks, because moving a whole array for each sample costs more than keeping some.
    if (samples.length > MAX_SAMPLES) samples.splice(0, CUT_SAMPLES);
    else if ((samples[0] as Sample).timeS < oldestS - CUT_S)
      samples.splice(
        0,
        samples.findIndex((each) => each.timeS >= oldestS),
      );
    return;
  }
  // The clock went back (a simulation or a bag started again): the old history belongs to an earlier run.
  if (sample.timeS < newest.timeS - HISTORY_S) {
    edge.samples = [sample];
    return;
  }
  const index = samples.findIndex((each) => each.timeS >= sample.timeS);
  if ((samples[index] as Sample).timeS === sample.timeS) samples[index] = sample;
  else samples.splice(index, 0, sample);
}

function sampleAt(edge: Edge, timeS: number): Transform | string {
  const { samples, child } = edge;
  const newest = samples.at(-1);
  if (newest === undefined) return `The frame ${child} has no transform yet.`;
  if (edge.isStatic || timeS === newest.timeS) return newest.transform;
  if (timeS > newest.timeS) return `The frame ${child} is ${(timeS - newest.timeS).toFixed(1)} s old.`;
  const oldest = samples[0] as Sample;
  if (timeS < oldest.timeS)
    return `The oldest transform of the frame ${child} is ${(oldest.timeS - timeS).toFixed(1)} s newer.`;
  let [low, high] = [0, samples.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if ((samples[middle] as Sample).timeS <= timeS) low = middle;
    else high = middle;
  }
  const a = samples[low] as Sample;
  const b = samples[high] as Sample;
  return interpolate(a.transform, b.transform, (timeS - a.timeS) / (b.timeS - a.timeS));
}

// One number of one topic over time, shared by all plots of it and kept while the page is open.
import type { Arrival } from "../store/feed.ts";
import type { Robot } from "../store/robot.ts";
import type { Topic } from "../store/topics.ts";
import { type PathReader, pathReader } from "../wire/path.ts";
import { RobotClock } from "./robot_clock.ts";
import { SeriesBuffer } from "./series_buffer.ts";
import { unitOf } from "./units.ts";

// Series that are no longer shown are dropped beyond this number; each may take 8 MB.
const MAX_SERIES = 64;

export class Series {
  /** `/imu_data.angular_velocity.z`: topics have no dots. */
  readonly id: string;
  readonly topicName: string;
  readonly path: string;
  readonly buffer = new SeriesBuffer();
  unit = "";
  /** Whether the series keeps a value until the next one, as a bool does. */
  isStepped = false;
  /** Why the series cannot be read; empty when it can. */
  error = "";
  /** For a path with `[:]`: the last numbers. */
  lastArray: ArrayLike<number | bigint> = [];
  readonly isArray: boolean;
  /** How many charts receive it now. */
  receivers = 0;
  private readonly clock: RobotClock;
  private topic: Topic | undefined;
  private reader: PathReader | undefined;
  private lastArrival: Arrival | undefined;

  constructor(id: string, clock: RobotClock) {
    this.id = id;
    const dot = id.indexOf(".");
    this.topicName = dot < 0 ? id : id.slice(0, dot);
    this.path = dot < 0 ? "" : id.slice(dot + 1);
    this.isArray = this.path.endsWith("[:]");
    this.clock = clock;
  }

  /** Sets the topic, whose type has the unit and is needed by `receive`. */
  follow(topic: Topic | undefined): void {
    if (topic === this.topic || topic === undefined) return;
    this.topic = topic;
    this.reader = undefined;
    this.error = "";
    try {
      const type = topic.type();
      this.reader = pathReader(type, this.path);
      this.unit = unitOf(type, this.path);
      this.isStepped = this.reader.isFlag;
    } catch (error) {
      this.error = (error as Error).message;
    }
  }

  receive(arrival: Arrival): void {
    if (!this.reader || arrival === this.lastArrival) return;
    this.lastArrival = arrival;
    const timeS = Number(arrival.timeNs) / 1e9;
    this.clock.note(timeS, arrival.receivedMs);
    if (this.isArray) this.lastArray = this.reader.readAll(arrival.payload);
    else this.buffer.push(timeS, this.reader.read(arrival.payload));
  }
}

class SeriesStore {
  readonly clock: RobotClock;
  private readonly byId = new Map<string, Series>();

  constructor(simulatedNs: () => bigint | undefined) {
    this.clock = new RobotClock(simulatedNs);
  }

  get(id: string): Series {
    let series = this.byId.get(id);
    if (series) this.byId.delete(id);
    else series = new Series(id, this.clock);
    // The most recently used series is dropped last.
    this.byId.set(id, series);
    if (this.byId.size > MAX_SERIES) this.byId.delete(this.byId.keys().next().value!);
    return series;
  }
}

const stores = new WeakMap<Robot, SeriesStore>();

export function seriesStore(robot: Robot): SeriesStore {
  let store = stores.get(robot);
  if (!store) {
    store = new SeriesStore(() => robot.simulatedTimeNs.peek());
    stores.set(robot, store);
  }
  return store;
}

// One topic's messages for all panels that show it: subscribed while at least one of them is visible.
import { type ReadonlySignal, type Signal, signal } from "@preact/signals";
import { decoder, type Message } from "../wire/decode.ts";
import { RateMeter } from "./rate.ts";
import type { Topic } from "./topics.ts";

/** A received message; `payload` may be kept, because nothing overwrites it. */
export interface Arrival {
  payload: Uint8Array;
  /** The time of arrival, `performance.now()`. */
  receivedMs: number;
  /** The gateway's clock, nanoseconds since 1970. */
  timeNs: bigint;
}
export type Listener = (arrival: Arrival) => void;

export class Feed {
  readonly topicName: string;
  /** The topic while it is on the graph. */
  readonly topic: Signal<Topic | undefined> = signal(undefined);
  readonly rate = new RateMeter();
  /** The last message; kept when the topic ends, and then stale. */
  last: Arrival | undefined;
  readonly listeners = new Set<Listener>();
  private readonly versionSignal = signal(0);
  private decoder: { topic: Topic; decode: (payload: Uint8Array) => Message } | undefined;
  private decoded: { arrival: Arrival; message: Message | Error } | undefined;

  constructor(topicName: string) {
    this.topicName = topicName;
  }

  /** Counts frames in which messages arrived; a component that reads it is drawn again, at most once a frame. */
  get version(): ReadonlySignal<number> {
    return this.versionSignal;
  }

  /** The last message, decoded once for all panels; an Error if it cannot be decoded. */
  lastMessage(): Message | Error | undefined {
    const arrival = this.last;
    if (!arrival) return undefined;
    if (this.decoded?.arrival !== arrival) {
      const message = this.decode(arrival.payload);
      if (message === undefined) return undefined;
      this.decoded = { arrival, message };
    }
    return this.decoded.message;
  }

  /** The last message; undefined if there is none, or if it cannot be decoded. */
  lastValid(): Message | undefined {
    const message = this.lastMessage();
    return message instanceof Error ? undefined : message;
  }

  /** Decodes any message of this topic; undefined while the topic's type is not known. */
  decode(payload: Uint8Array): Message | Error | undefined {
    const topic = this.topic.peek();
    if (!topic) return undefined;
    try {
      if (this.decoder?.topic !== topic) this.decoder = { topic, decode: decoder(topic.type()) };
      return this.decoder.decode(payload);
    } catch (error) {
      return error as Error;
    }
  }

  isStale(nowMs = performance.now()): boolean {
    return this.rate.isStale(nowMs);
  }

  receive(arrival: Arrival): void {
    this.last = arrival;
    this.rate.add(arrival.receivedMs, arrival.payload.length);
    for (const each of this.listeners) each(arrival);
  }

  /** Draws the views of this feed again; the store calls it once a frame. */
  bump(): void {
    this.versionSignal.value++;
  }
}

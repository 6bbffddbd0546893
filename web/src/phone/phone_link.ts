// A separate connection for the phone's sensors, so that pictures never delay a stop.
import { type Signal, signal } from "@preact/signals";
import { gatewayUrl } from "../connection/address.ts";
import { gatewaySocket } from "../connection/gateway_socket.ts";
import { messageData } from "../connection/protocol.ts";
import type { ReconnectingSocket } from "../connection/socket.ts";
import type { Stamp } from "../wire/stamp.ts";
import { ClockOffset, pageTimeMs } from "./clock_offset.ts";

// The page asks for the robot's time at short intervals at first, then often enough for the drift of any clock.
const FIRST_ASKS = 5;
const FIRST_ASK_MS = 200;
const ASK_MS = 10_000;
// With more waiting bytes, messages are dropped: newer values matter more.
const MAX_WAITING_BYTES = 64 * 1024;

export class PhoneLink {
  private readonly clock = new ClockOffset();
  /** The offset of the robot's clock and the time of the answer, in milliseconds. */
  readonly offset: Signal<{ offsetMs: number; roundTripMs: number } | undefined> = signal(undefined);
  /** An error of the robot. */
  readonly problem = signal("");
  private readonly socket: ReconnectingSocket;
  private readonly topics = new Map<number, { topic: string; schemaName: string }>();
  private readonly asked = new Map<number, number>();
  private simulated: Stamp | undefined;
  private isOpen = false;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private asks = 0;
  private nextId = 1;

  constructor() {
    this.socket = gatewaySocket(gatewayUrl, {
      onOpen: () => {
        for (const [id, each] of this.topics) this.advertise(id, each);
        this.simulated = undefined;
        this.clock.clear();
        this.asks = 0;
        this.ask();
        this.isOpen = true;
      },
      onText: (message) => {
        if (message.op === "timeAnswer") this.learn(message.id, message);
        // Statuses with an id are not about this connection.
        if (message.op === "status" && message.level > 0 && message.id === undefined)
          this.problem.value = message.message;
      },
      onBinary: (message) => {
        if (message.op !== "time") return;
        const ns = 1_000_000_000n;
        this.simulated = { sec: Number(message.timeNs / ns), nsec: Number(message.timeNs % ns) };
      },
      onClose: () => {
        clearTimeout(this.timer);
        this.asked.clear();
        this.isOpen = false;
      },
    });
  }

  /** Advertises a topic; returns its id. */
  open(topic: string, schemaName: string): number {
    const id = this.nextId++;
    this.topics.set(id, { topic, schemaName });
    this.advertise(id, { topic, schemaName });
    return id;
  }

  end(id: number): void {
    if (this.topics.delete(id)) this.socket.send({ op: "unadvertise", channelIds: [id] });
  }

  /** The robot's time at a time of the page; undefined before it is known. */
  stamp(pageMs: number): Stamp | undefined {
    return this.simulated ?? this.clock.stamp(pageMs);
  }

  /** Whether a message would be sent without a long wait. */
  get hasRoom(): boolean {
    return this.isOpen && this.socket.waitingBytes < MAX_WAITING_BYTES;
  }

  /** Publishes a message; returns false, and drops it, when the connection is slow or lost. */
  publish(id: number, payload: Uint8Array): boolean {
    return this.hasRoom && this.socket.send(messageData(id, payload));
  }

  close(): void {
    clearTimeout(this.timer);
    this.socket.close();
  }

  private advertise(id: number, topic: { topic: string; schemaName: string }): void {
    this.socket.send({ op: "advertise", channels: [{ id, encoding: "ros1", ...topic }] });
  }

  private ask(): void {
    const id = this.nextId++;
    this.asked.clear();
    this.asked.set(id, pageTimeMs());
    this.socket.send({ op: "askTime", id });
    this.timer = setTimeout(() => this.ask(), ++this.asks < FIRST_ASKS ? FIRST_ASK_MS : ASK_MS);
  }

  private learn(id: number, robot: Stamp): void {
    const askedMs = this.asked.get(id);
    if (askedMs === undefined) return;
    this.asked.delete(id);
    this.clock.add(askedMs, pageTimeMs(), robot);
    this.offset.value = this.clock.best;
  }
}

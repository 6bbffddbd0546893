// Drives one topic: repeats the command while the stick is held, then zeros for half a second, then is silent.
import { type Signal, signal } from "@preact/signals";
import type { Lease } from "../../connection/protocol.ts";
import type { Robot } from "../../store/robot.ts";
import type { Topic } from "../../store/topics.ts";
import { encoder } from "../../wire/encode.ts";
import type { StructNode } from "../../wire/schema.ts";
import { CENTER, commandOf, type Limits, type Stick } from "./commands.ts";

// The gateway stops the robot 125 ms after the last command; two may be lost.
const PERIOD_MS = 40;
// After a longer sleep of the page, the robot has stopped, and only a new touch starts it.
const ASLEEP_MS = 1000;
// Other sources of commands must not be masked forever.
const ZEROS_MS = 500;

export class Driver {
  readonly lease: Signal<Lease> = signal({ state: "free", driver: "" });
  /** Where the stick is, for display. */
  readonly stick: Signal<Stick> = signal(CENTER);
  /** Whether the held stick has no effect until it is released. */
  readonly isBlocked: Signal<boolean> = signal(false);
  limits: Limits;
  private readonly robot: Robot;
  /** The type of the commands. */
  readonly commandType: StructNode;
  private readonly encode: (message: unknown) => Uint8Array;
  private readonly id: number;
  private timer: ReturnType<typeof setInterval> | undefined;
  private repeatedMs = 0;
  private startedMs = 0;
  private wasSilent = false;
  private releasedMs: number | undefined;

  /** Throws DefinitionError when the type is not known. */
  constructor(robot: Robot, topic: Topic, limits: Limits) {
    this.robot = robot;
    this.commandType = topic.type();
    this.encode = encoder(this.commandType);
    this.limits = limits;
    const channel = { topic: topic.name, schemaName: topic.typeName, schema: topic.definition };
    this.id = robot.gateway.advertiseDriven(channel, nameOfDevice(), (lease) => {
      // Another client drives or has stopped the robot: a stick that is still held must not start it again.
      if (lease.state === "taken" && this.timer !== undefined) this.block();
      // The robot got no commands for a second, because the network stalled: it has stopped.
      if (lease.state === "free" && this.lease.peek().state === "driving" && this.heldMs() > ASLEEP_MS) {
        this.wasSilent = true;
        this.block();
      }
      this.lease.value = lease;
    });
  }

  /** Whether turning has a separate limit; a direction with a speed has none. */
  get hasTurnLimit(): boolean {
    return this.commandType.name !== "arduino_control/ArduinoControl";
  }

  /** Drives with this stick position until `release`. */
  hold(stick: Stick): void {
    if (this.isBlocked.peek()) return;
    if (this.timer === undefined && this.lease.peek().state === "taken" && stick !== CENTER) {
      // The stick must not begin to drive when the other client stops driving.
      this.isBlocked.value = true;
      return;
    }
    this.releasedMs = undefined;
    this.stick.value = stick;
    if (this.timer === undefined) {
      this.startedMs = this.repeatedMs = performance.now();
      // If a driver was silent while the robot moved, the robot first waits for its stop.
      if (this.wasSilent) this.publish(CENTER);
      this.wasSilent = false;
      this.timer = setInterval(() => this.repeat(), PERIOD_MS);
      this.repeat();
    }
  }

  /** Releases the stick: the robot stops. */
  release(): void {
    this.isBlocked.value = false;
    this.stick.value = CENTER;
    if (this.timer === undefined) return;
    this.releasedMs ??= performance.now();
    this.repeat();
  }

  /** Stops now, even when nothing was held. */
  stop(): void {
    this.isBlocked.value = false;
    this.hold(CENTER);
    this.release();
  }

  dispose(): void {
    clearInterval(this.timer);
    if (this.timer !== undefined) this.publish(CENTER);
    this.robot.gateway.unadvertise(this.id);
  }

  private repeat(): void {
    const nowMs = performance.now();
    const wasAsleep = nowMs - this.repeatedMs > ASLEEP_MS;
    this.repeatedMs = nowMs;
    if (this.releasedMs === undefined && (wasAsleep || !this.robot.canCommand.peek())) {
      this.wasSilent = wasAsleep;
      this.block();
      return;
    }
    this.publish(this.releasedMs === undefined ? this.stick.value : CENTER);
    if (this.releasedMs !== undefined && nowMs - this.releasedMs > ZEROS_MS) this.end();
  }

  /** How long the stick has been held. */
  private heldMs(): number {
    const isHeld = this.timer !== undefined && this.releasedMs === undefined;
    return isHeld ? performance.now() - this.startedMs : 0;
  }

  private block(): void {
    this.isBlocked.value = true;
    this.end();
  }

  private end(): void {
    clearInterval(this.timer);
    this.timer = undefined;
    this.releasedMs = undefined;
    this.stick.value = CENTER;
  }

  private publish(stick: Stick): void {
    this.robot.gateway.publish(this.id, this.encode(commandOf(this.commandType, stick, this.limits)));
  }
}

/** The driver's name for other users. */
function nameOfDevice(): string {
  const { userAgent } = navigator;
  const kind = /Android|iPhone|iPad/.exec(userAgent)?.[0] ?? /Windows|Mac OS|CrOS|Linux/.exec(userAgent)?.[0];
  return kind ?? "browser";
}

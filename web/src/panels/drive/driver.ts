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
// Other sources of commands must not be masked for ever.
const ZEROS_MS = 500;

export class Driver {
  readonly lease: Signal<Lease> = signal({ state: "free", driver: "" });
  /** Where the stick is, for display. */
  readonly stick: Signal<Stick> = signal(CENTER);
  limits: Limits;
  private readonly robot: Robot;
  private readonly type: StructNode;
  private readonly encode: (message: unknown) => Uint8Array;
  private readonly id: number;
  private timer: ReturnType<typeof setInterval> | undefined;
  private isBlocked = false;
  private releasedMs: number | undefined;

  /** Throws DefinitionError when the type is not known. */
  constructor(robot: Robot, topic: Topic, limits: Limits) {
    this.robot = robot;
    this.type = topic.type();
    this.encode = encoder(this.type);
    this.limits = limits;
    const channel = { topic: topic.name, schemaName: topic.typeName, schema: topic.definition };
    this.id = robot.gateway.advertiseDriven(channel, nameOfDevice(), (lease) => {
      // Another client drives or has stopped the robot: a stick that is still held must not start it again.
      if (lease.state === "taken" && this.timer !== undefined) {
        this.isBlocked = true;
        this.end();
      }
      this.lease.value = lease;
    });
  }

  /** The type of the commands. */
  get typeOf(): StructNode {
    return this.type;
  }

  /** Whether turning has a limit of its own; a direction with a speed has none. */
  get hasTurnLimit(): boolean {
    return this.type.name !== "arduino_control/ArduinoControl";
  }

  /** Drive with this stick position until `release`. */
  hold(stick: Stick): void {
    if (this.isBlocked) return;
    this.releasedMs = undefined;
    this.stick.value = stick;
    if (this.timer === undefined) {
      this.timer = setInterval(() => this.repeat(), PERIOD_MS);
      this.repeat();
    }
  }

  /** Let go: the robot stops. */
  release(): void {
    this.isBlocked = false;
    this.stick.value = CENTER;
    if (this.timer === undefined) return;
    this.releasedMs ??= performance.now();
    this.repeat();
  }

  /** Stop now, also when nothing was held. */
  stop(): void {
    this.isBlocked = false;
    this.hold(CENTER);
    this.release();
  }

  dispose(): void {
    clearInterval(this.timer);
    if (this.timer !== undefined) this.publish(CENTER);
    this.robot.gateway.unadvertise(this.id);
  }

  private repeat(): void {
    this.publish(this.releasedMs === undefined ? this.stick.value : CENTER);
    if (this.releasedMs !== undefined && performance.now() - this.releasedMs > ZEROS_MS) {
      this.end();
    }
  }

  private end(): void {
    clearInterval(this.timer);
    this.timer = undefined;
    this.releasedMs = undefined;
    this.stick.value = CENTER;
  }

  private publish(stick: Stick): void {
    this.robot.gateway.publish(this.id, this.encode(commandOf(this.type, stick, this.limits)));
  }
}

/** The driver's name for other users. */
function nameOfDevice(): string {
  const { userAgent } = navigator;
  const kind = /Android|iPhone|iPad/.exec(userAgent)?.[0] ?? /Windows|Mac OS|CrOS|Linux/.exec(userAgent)?.[0];
  return kind ?? "browser";
}

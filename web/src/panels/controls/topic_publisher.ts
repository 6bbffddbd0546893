// Publishes to one topic while a control is shown.
import type { Robot } from "../../store/robot.ts";
import type { Topic } from "../../store/topics.ts";
import { encoder } from "../../wire/encode.ts";

// A slider moves at the screen's rate; boards with 57,600 baud read about 100 messages a second.
const MIN_PERIOD_MS = 50;

export class TopicPublisher {
  private readonly robot: Robot;
  private readonly id: number;
  private readonly encode: (message: unknown) => Uint8Array;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private waiting: { message: unknown } | undefined;

  /** Throws DefinitionError when the type cannot be written. */
  constructor(robot: Robot, topic: Topic) {
    this.robot = robot;
    this.encode = encoder(topic.type());
    this.id = robot.gateway.advertise(topic.name, topic.typeName, topic.definition);
  }

  /** Publishes immediately. Returns whether it was sent; throws EncodeError. */
  publish(message: unknown): boolean {
    return this.robot.gateway.publish(this.id, this.encode(message));
  }

  /** Publishes at most 20 times a second; the last value is always sent. */
  publishSmoothly(message: unknown): void {
    if (this.timer !== undefined) {
      this.waiting = { message };
      return;
    }
    this.publish(message);
    this.timer = setTimeout(() => {
      this.timer = undefined;
      const next = this.waiting;
      this.waiting = undefined;
      if (next !== undefined) this.publishSmoothly(next.message);
    }, MIN_PERIOD_MS);
  }

  dispose(): void {
    clearTimeout(this.timer);
    if (this.waiting !== undefined) this.publish(this.waiting.message);
    this.robot.gateway.unadvertise(this.id);
  }
}

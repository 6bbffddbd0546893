// The robot's parameters: read when a panel asks, then followed.
import { type Signal, signal } from "@preact/signals";
import type { Gateway } from "../connection/gateway.ts";
import type { Parameter } from "../connection/protocol.ts";

// The gateway's limit for one client.
const MAX_WATCHED = 1000;

export class Parameters {
  /** The values known so far; empty until `refresh`. */
  readonly values: Signal<ReadonlyMap<string, Parameter>> = signal(new Map());
  private readonly gateway: Gateway;
  private readonly watched = new Set<string>();

  constructor(gateway: Gateway) {
    this.gateway = gateway;
  }

  /** Reads all parameters and follows their changes. Rejects with GatewayError. */
  async refresh(): Promise<void> {
    const found = await this.gateway.getParameters();
    this.values.value = new Map(found.map((each) => [each.name, each]));
    const names = found.map((each) => each.name).filter((name) => !this.watched.has(name));
    const watchable = names.slice(0, Math.max(0, MAX_WATCHED - this.watched.size));
    for (const name of watchable) this.watched.add(name);
    if (watchable.length > 0) this.gateway.watchParameters(watchable);
  }

  /** Sets one parameter; resolves when the robot has it. Rejects with GatewayError. */
  async set(name: string, value: unknown, type?: string): Promise<void> {
    await this.gateway.setParameters([type === undefined ? { name, value } : { name, value, type }]);
  }

  receive(parameters: Parameter[]): void {
    if (parameters.length === 0) return;
    const values = new Map(this.values.value);
    for (const each of parameters) {
      // A parameter without a value was deleted.
      if (each.value === undefined || each.value === null) values.delete(each.name);
      else values.set(each.name, each);
    }
    this.values.value = values;
  }
}

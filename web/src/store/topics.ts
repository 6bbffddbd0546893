// A topic of the graph with its definition.
import type { Channel } from "../connection/protocol.ts";
import { parseDefinition } from "../wire/definition.ts";
import type { StructNode } from "../wire/schema.ts";

/** Whether ROS 2 tools leave a topic out of their lists: a part of its name begins with an underscore. */
export function isHidden(name: string): boolean {
  return name.includes("/_");
}

export class Topic {
  readonly name: string;
  /** For example `sensor_msgs/Range`. */
  readonly typeName: string;
  readonly definition: string;
  /** Undefined for a topic that only has subscribers: nothing can be received from it. */
  readonly channelId: number | undefined;
  private parsed: StructNode | Error | undefined;

  constructor(name: string, typeName: string, definition: string, channelId: number | undefined) {
    this.name = name;
    this.typeName = typeName;
    this.definition = definition;
    this.channelId = channelId;
  }

  static ofChannel(channel: Channel): Topic {
    return new Topic(channel.topic, channel.schemaName, channel.schema, channel.id);
  }

  /** Whether a node publishes it, so that the page can subscribe to it. */
  get isPublished(): boolean {
    return this.channelId !== undefined;
  }

  /** The tree of its type; throws DefinitionError. Definitions are parsed only when something reads them. */
  type(): StructNode {
    if (this.parsed === undefined) {
      try {
        this.parsed = parseDefinition(this.typeName, this.definition);
      } catch (error) {
        this.parsed = error as Error;
      }
    }
    if (this.parsed instanceof Error) throw this.parsed;
    return this.parsed;
  }
}

// The graph as panels see it.
import type { Robot } from "../store/robot.ts";
import type { Graph } from "./panel.ts";

/** Reading it in a computed signal follows its changes. */
export function graphOf(robot: Robot): Graph {
  return {
    topics: robot.topics.value,
    publishers: robot.publishers.value,
    subscribers: robot.subscribers.value,
    services: robot.services.value,
    ownNode: robot.info.value?.metadata?.node,
  };
}

/** Whether a node subscribes to a topic; the gateway's node does so only to show it. */
export function hasSubscriber({ subscribers, ownNode }: Graph, topic: string): boolean {
  return subscribers.get(topic)?.some((node) => node !== ownNode) ?? false;
}

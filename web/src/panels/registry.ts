// All panels, in the order of the navigation.
import type { Robot } from "../store/robot.ts";
import { boardsPanel } from "./boards/boards.ts";
import type { Graph, Panel } from "./panel.ts";
import { topicsPanel } from "./topics/topics.ts";

export const panels: readonly Panel[] = [boardsPanel, topicsPanel];

/** The graph as panels see it; reading it in a computed signal follows its changes. */
export function graphOf(robot: Robot): Graph {
  return {
    topics: robot.topics.value,
    publishers: robot.publishers.value,
    subscribers: robot.subscribers.value,
    services: robot.services.value,
  };
}

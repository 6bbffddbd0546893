// The graph as panels see it.
import type { Robot } from "../store/robot.ts";
import { boardsOf } from "./boards/board_history.ts";
import type { Graph } from "./panel.ts";

/** Returns the current graph. A computed signal that calls this follows its changes. */
export function graphOf(robot: Robot): Graph {
  const { node = "", teleop_node: teleopNode = "" } = robot.info.value?.metadata ?? {};
  return {
    topics: robot.topics.value,
    publishers: robot.publishers.value,
    subscribers: robot.subscribers.value,
    services: robot.services.value,
    ownNodes: [node, teleopNode],
    hasBoards: boardsOf(robot).byName.size > 0,
  };
}

// The nodes of other dashboards on the graph: `dashboard`, and `dashboard_8766` on another port.
const DASHBOARD = /\/(dashboard|web_teleop)(_\d+)?$/;

/** Whether a node only publishes and subscribes for pages, of this or of another dashboard. */
export function isPageNode({ ownNodes }: Graph, node: string): boolean {
  return ownNodes.includes(node) || DASHBOARD.test(node);
}

/** Whether a node subscribes to a topic; the gateway's nodes do so only to show it. */
export function hasSubscriber(graph: Graph, topic: string): boolean {
  return graph.subscribers.get(topic)?.some((node) => !isPageNode(graph, node)) ?? false;
}

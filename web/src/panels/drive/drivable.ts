// Which topics are commands that drive something.
import { hasSubscriber } from "../graph_of.ts";
import type { Graph } from "../panel.ts";
import { DRIVE_TYPES } from "./commands.ts";

/** The command topics that a node subscribes to, in order. */
export function drivableTopics(graph: Graph): string[] {
  return [...graph.topics.values()]
    .filter((each) => DRIVE_TYPES.includes(each.typeName) && hasSubscriber(graph, each.name))
    .map((each) => each.name)
    .sort();
}

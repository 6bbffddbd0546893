// Which topics accept input: a node subscribes, and no other node publishes.
import { hasSubscriber, isPageNode } from "../graph_of.ts";
import type { Graph } from "../panel.ts";

// Topics that are for tools or belong to every node.
const NOT_FOR_PEOPLE =
  /^\/(rosout|rosout_agg|clock|tf|tf_static|diagnostics|parameter_events)$|\/(feedback|status|result|goal|cancel)$|_simulation\/command$/;

/** Topics that a person can control. */
export function controllableTopics(graph: Graph): string[] {
  const { topics, publishers, subscribers } = graph;
  const isFree = (topic: string) => publishers.get(topic)?.every((node) => isPageNode(graph, node)) ?? true;
  return [...subscribers.keys()]
    .filter(
      (each) => !NOT_FOR_PEOPLE.test(each) && topics.has(each) && hasSubscriber(graph, each) && isFree(each),
    )
    .sort();
}

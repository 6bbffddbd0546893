// The fields of a topic for a plot on the overview.
import { compareNames } from "../../shell/format.ts";
import type { Topic } from "../../store/topics.ts";
import { numericPaths } from "../../wire/path.ts";
import { isPageNode } from "../graph_of.ts";
import { MAIN_FIELDS } from "../main_fields.ts";
import type { Graph, Suggestion } from "../panel.ts";

/** Packages whose other messages cannot be plotted usefully, or are shown by other panels. */
const OTHER =
  /^(sensor_msgs|geometry_msgs|nav_msgs|visualization_msgs|tf2?_msgs|tf|actionlib_msgs|diagnostic_msgs|rosgraph_msgs|rcl_interfaces|action_msgs|lifecycle_msgs|service_msgs|type_description_interfaces|std_srvs|shape_msgs|stereo_msgs|trajectory_msgs|bond|dynamic_reconfigure)\//;
/** The number of rosbridge's clients. */
const NO_SENSORS = new Set(["/client_count"]);
// The values of more lines do not fit on a card.
const MAX_PATHS = 3;
// More cards would hide those of other panels.
const MAX_CARDS = 16;

/** The paths of a topic to plot first; none when it has no number that people would look at. */
export function mainPaths(topic: Topic): string[] {
  const known = MAIN_FIELDS[topic.typeName];
  if (known) return known;
  if (OTHER.test(topic.typeName)) return [];
  try {
    return numericPaths(topic.type(), 20)
      .filter((path) => !path.endsWith("[:]"))
      .slice(0, MAX_PATHS);
  } catch {
    return [];
  }
}

/** The topic, and the field of the number if the topic has several. */
function titleOf(topic: Topic, paths: readonly string[]): string {
  const [path = "", ...others] = paths;
  const isPlain = others.length > 0 || path === "data" || topic.typeName in MAIN_FIELDS;
  return isPlain ? topic.name : `${topic.name}/${path.replaceAll(".", "/")}`;
}

/** Whether only pages publish a topic: it has a control instead. */
function isOwn(topic: string, graph: Graph): boolean {
  const nodes = graph.publishers.get(topic) ?? [];
  return nodes.length > 0 && nodes.every((node) => isPageNode(graph, node));
}

export function plotSuggestions(graph: Graph): Suggestion[] {
  const found: Suggestion[] = [];
  for (const topic of graph.topics.values()) {
    if (!topic.isPublished || NO_SENSORS.has(topic.name) || isOwn(topic.name, graph)) continue;
    const paths = mainPaths(topic);
    if (paths.length === 0) continue;
    const series = paths.map((path) => `${topic.name}.${path}`);
    found.push({
      key: topic.name,
      title: titleOf(topic, paths),
      settings: { series },
      order: topic.typeName in MAIN_FIELDS ? 30 : 35,
    });
  }
  // Sensors first: counters are less interesting.
  return found.sort((a, b) => a.order - b.order || compareNames(a.key, b.key)).slice(0, MAX_CARDS);
}

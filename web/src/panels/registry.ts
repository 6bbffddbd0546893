// All panels, in the order of the navigation.
import type { Robot } from "../store/robot.ts";
import { boardsPanel } from "./boards/boards.ts";
import { consolePanel } from "./console/console.ts";
import { controlsPanel } from "./controls/controls.ts";
import { diagnosticsPanel } from "./diagnostics/diagnostics.ts";
import { drivePanel } from "./drive/drive.ts";
import { framesPanel } from "./frames/frames.ts";
import { graphPanel } from "./graph/graph.ts";
import { imagesPanel } from "./images/images.ts";
import { mapPanel } from "./map/map.ts";
import type { Graph, Panel } from "./panel.ts";
import { parametersPanel } from "./parameters/parameters.ts";
import { scenePanel } from "./scene/scene.ts";
import { servicesPanel } from "./services/services.ts";
import { topicsPanel } from "./topics/topics.ts";

export const panels: readonly Panel[] = [
  boardsPanel,
  controlsPanel,
  drivePanel,
  imagesPanel,
  scenePanel,
  mapPanel,
  graphPanel,
  topicsPanel,
  servicesPanel,
  parametersPanel,
  consolePanel,
  diagnosticsPanel,
  framesPanel,
];

/** The graph as panels see it; reading it in a computed signal follows its changes. */
export function graphOf(robot: Robot): Graph {
  return {
    topics: robot.topics.value,
    publishers: robot.publishers.value,
    subscribers: robot.subscribers.value,
    services: robot.services.value,
    ownNode: robot.info.value?.metadata?.node,
  };
}

// All panels, in the order and the groups of the navigation.
import { boardsPanel } from "./boards/boards.ts";
import { connectPanel } from "./connect/connect.ts";
import { consolePanel } from "./console/console.ts";
import { controlsPanel } from "./controls/controls.ts";
import { diagnosticsPanel } from "./diagnostics/diagnostics.ts";
import { drivePanel } from "./drive/drive.ts";
import { fleetPanel } from "./fleet/fleet.ts";
import { framesPanel } from "./frames/frames.ts";
import { graphPanel } from "./graph/graph.ts";
import { imagesPanel } from "./images/images.ts";
import { mapPanel } from "./map/map.ts";
import type { Panel } from "./panel.ts";
import { parametersPanel } from "./parameters/parameters.ts";
import { phonePanel } from "./phone/phone.ts";
import { plotsPanel } from "./plots/plots.ts";
import { recordingPanel } from "./recording/recording.ts";
import { scenePanel } from "./scene/scene.ts";
import { sensorsPanel } from "./sensors/sensors.ts";
import { servicesPanel } from "./services/services.ts";
import { simulationPanel } from "./simulation/simulation.ts";
import { topicsPanel } from "./topics/topics.ts";

/** The groups of the menu: the robot and its control, its data, the ROS graph, and tools. */
export const panelGroups: readonly (readonly Panel[])[] = [
  [boardsPanel, fleetPanel, sensorsPanel, controlsPanel, drivePanel],
  [plotsPanel, imagesPanel, scenePanel, mapPanel],
  [graphPanel, topicsPanel, servicesPanel, parametersPanel, consolePanel, diagnosticsPanel, framesPanel],
  [recordingPanel, simulationPanel, connectPanel, phonePanel],
];

export const panels: readonly Panel[] = panelGroups.flat();

// Finds the robot description: the parameter (ROS 1) or the latched topic (ROS 2) robot_description.
import { effect } from "@preact/signals";
import type { PanelContext } from "../panels/panel.ts";

const PARAMETER = "/robot_description";

/** Calls `onText` with each new description, until the returned function is called. */
export function followRobotDescription(context: PanelContext, onText: (urdf: string) => void): () => void {
  const { robot } = context;
  let shown = "";
  const offer = (text: unknown) => {
    if (typeof text !== "string" || text === "" || text === shown) return;
    shown = text;
    onText(text);
  };
  const { feed, close } = context.subscribe(PARAMETER, () => offer(feed.lastValid()?.data));
  // The panel that shares the subscription has already received a latched description.
  offer(feed.lastValid()?.data);
  const endRead = effect(() => {
    if (!robot.canCommand.value) return;
    robot.gateway
      .getParameters([PARAMETER])
      .then(([found]) => {
        offer(found?.value);
        robot.gateway.watchParameters([PARAMETER]);
      })
      // Without the parameter there may be the topic; a robot without either has no model.
      .catch(() => undefined);
  });
  const endFollow = effect(() => offer(robot.parameters.values.value.get(PARAMETER)?.value));
  return () => {
    close();
    endRead();
    endFollow();
  };
}

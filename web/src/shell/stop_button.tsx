// The stop button in the header: on every page, as soon as there is something to drive.
import { useComputed } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { drivableTopics } from "../panels/drive/drivable.ts";
import { prepareStop, stopAll } from "../panels/drive/drivers.ts";
import { graphOf } from "../panels/graph_of.ts";
import type { Robot } from "../store/robot.ts";
import { texts } from "../texts.ts";
import { Icon } from "./icons.tsx";

export function StopButton({ robot }: { robot: Robot }) {
  const topics = useComputed(() =>
    robot.mayAct.value ? drivableTopics(graphOf(robot)).join(" ") : "",
  ).value;
  useEffect(() => prepareStop(robot), [topics]);
  if (topics === "") return null;
  return (
    <button type="button" class="stop" onPointerDown={() => stopAll(robot)} onClick={() => stopAll(robot)}>
      <Icon name="stop" />
      <span>{texts.drive.stop}</span>
    </button>
  );
}

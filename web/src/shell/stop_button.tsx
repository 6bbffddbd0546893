// The stop button in the header: on every page, as soon as there is something to drive.
import { useComputed } from "@preact/signals";
import { drivableTopics } from "../panels/drive/drivable.ts";
import { stopAll } from "../panels/drive/drivers.ts";
import { graphOf } from "../panels/graph_of.ts";
import type { Robot } from "../store/robot.ts";
import { texts } from "../texts.ts";
import { Icon } from "./icons.tsx";

export function StopButton({ robot }: { robot: Robot }) {
  const canDrive = useComputed(() => robot.mayAct.value && drivableTopics(graphOf(robot)).length > 0).value;
  if (!canDrive) return null;
  return (
    <button type="button" class="stop" onPointerDown={() => stopAll(robot)} onClick={() => stopAll(robot)}>
      <Icon name="stop" />
      <span>{texts.drive.stop}</span>
    </button>
  );
}

// A slider for each joint of the robot description; publishes sensor_msgs/JointState.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { followRobotDescription } from "../../scene/robot_description.ts";
import { formatNumber } from "../../shell/format.ts";
import { texts } from "../../texts.ts";
import { stampNow } from "../../wire/stamp.ts";
import type { PanelContext } from "../panel.ts";
import { type Joint, readJoints } from "./joint_limits.ts";

const DEGREES = 180 / Math.PI;

export function JointSliders(props: {
  context: PanelContext;
  send: (message: Record<string, unknown>) => void;
}) {
  const { context, send } = props;
  const joints = useSignal<Joint[]>([]);
  const positions = useSignal<Record<string, number>>({});
  useEffect(
    () =>
      followRobotDescription(context, (urdf) => {
        joints.value = readJoints(urdf);
      }),
    [],
  );
  const middle = ({ lower, upper }: Joint) => (lower <= 0 && upper >= 0 ? 0 : (lower + upper) / 2);
  const positionOf = (joint: Joint) => positions.value[joint.name] ?? middle(joint);
  const publish = () => {
    send({
      header: { stamp: stampNow(), frame_id: "" },
      name: joints.value.map((joint) => joint.name),
      position: joints.value.map(positionOf),
    });
  };
  const set = (name: string, position: number) => {
    positions.value = { ...positions.value, [name]: position };
    publish();
  };
  if (joints.value.length === 0) return <p class="empty-line">{texts.controls.noJoints}</p>;
  return (
    <div class="joints">
      {joints.value.map((joint) => (
        <label key={joint.name} class="joint">
          <span class="form-name">{joint.name}</span>
          <input
            type="range"
            min={joint.lower}
            max={joint.upper}
            step={(joint.upper - joint.lower) / 500 || 0.001}
            value={positionOf(joint)}
            onInput={(event) => set(joint.name, event.currentTarget.valueAsNumber)}
          />
          <span class="number">
            {joint.isRevolute
              ? `${formatNumber(positionOf(joint) * DEGREES, 3)}°`
              : `${formatNumber(positionOf(joint), 3)} m`}
          </span>
        </label>
      ))}
      <button
        type="button"
        class="button"
        onClick={() => {
          positions.value = {};
          publish();
        }}
      >
        {texts.controls.center}
      </button>
    </div>
  );
}

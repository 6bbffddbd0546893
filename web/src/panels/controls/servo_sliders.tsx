// A slider for each angle of a message for several servos, such as mearm_model/ServoAngles.
import { useSignal } from "@preact/signals";
import type { PanelContext } from "../panel.ts";
import type { ControlKind } from "./control_kind.ts";
import { useOthersValue } from "./others_value.ts";

export function ServoSliders(props: {
  context: PanelContext;
  topicName: string;
  servos: ControlKind & { kind: "servos" };
  send: (message: Record<string, unknown>) => void;
}) {
  const { context, topicName, servos, send } = props;
  const { fields, min, max, step } = servos;
  const angles = useSignal<Record<string, number>>(
    Object.fromEntries(fields.map((field) => [field, (min + max) / 2])),
  );
  const noteSent = useOthersValue(context, topicName, (message) => {
    angles.value = Object.fromEntries(fields.map((field) => [field, Number(message[field])]));
  });
  const set = (field: string, angle: number) => {
    angles.value = { ...angles.value, [field]: angle };
    noteSent();
    send(angles.value);
  };
  return (
    <div class="joints">
      {fields.map((field) => (
        <label key={field} class="joint">
          <span class="form-name">{field}</span>
          <input
            type="range"
            min={min}
            max={max}
            step={step}
            value={angles.value[field]!}
            onInput={(event) => set(field, event.currentTarget.valueAsNumber)}
          />
          <span class="number">{angles.value[field]}°</span>
        </label>
      ))}
    </div>
  );
}

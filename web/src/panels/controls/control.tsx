// One control of one topic.
import { type Signal, useSignal } from "@preact/signals";
import type { TargetedEvent } from "preact";
import { useEffect, useMemo } from "preact/hooks";
import { type Draft, MessageForm } from "../../forms/message_form.tsx";
import { parseNumber } from "../../forms/numbers.ts";
import { texts } from "../../texts.ts";
import type { Primitive, StructNode } from "../../wire/schema.ts";
import type { PanelContext } from "../panel.ts";
import { type ControlKind, controlKind } from "./control_kind.ts";
import { JointSliders } from "./joint_sliders.tsx";
import { useOthersValue } from "./others_value.ts";
import { ServoSliders } from "./servo_sliders.tsx";
import { TopicPublisher } from "./topic_publisher.ts";

/** Publishes a message, now or with `smoothly` at a limited rate; returns whether it can be sent. */
type Send = (message: Draft, smoothly?: boolean) => boolean;

/** Ranges of sliders that the user changed, by topic. */
export interface ControlSettings {
  ranges?: Record<string, { min: number; max: number }>;
}

export function Control({ context, topicName }: { context: PanelContext; topicName: string }) {
  const { robot } = context;
  const topic = robot.topics.value.get(topicName);
  const problem = useSignal("");
  const publisher = useMemo(() => {
    if (topic === undefined) return undefined;
    try {
      return { type: topic.type(), publisher: new TopicPublisher(robot, topic) };
    } catch (error) {
      problem.value = (error as Error).message;
      return undefined;
    }
  }, [topic?.name, topic?.definition]);
  useEffect(() => () => publisher?.publisher.dispose(), [publisher]);
  if (publisher === undefined) return problem.value ? <p class="problem">{problem.value}</p> : null;
  const isReadOnly = !robot.mayAct.value;
  const send: Send = (message, smoothly) => {
    try {
      if (smoothly) publisher.publisher.publishSmoothly(message);
      else if (!publisher.publisher.publish(message)) throw new Error(texts.controls.notSent);
      problem.value = "";
      return true;
    } catch (error) {
      problem.value = (error as Error).message;
      return false;
    }
  };
  return (
    <div class="control">
      <div class="control-head">
        {/* A card has the topic as its title. */}
        {!context.isCard && <span class="control-topic">{topicName}</span>}
        <span class="form-type">{publisher.type.name}</span>
      </div>
      <fieldset class="control-body" disabled={isReadOnly}>
        <ControlOf context={context} topicName={topicName} type={publisher.type} send={send} />
      </fieldset>
      {problem.value && <p class="problem">{problem.value}</p>}
    </div>
  );
}

function ControlOf(props: { context: PanelContext; topicName: string; type: StructNode; send: Send }) {
  const { context, topicName, type, send } = props;
  const kind = controlKind(topicName, type);
  switch (kind.kind) {
    case "button":
      return <PushButton send={send} label={topicName.split("/").at(-1) ?? topicName} />;
    case "toggle":
      return <TopicToggle context={context} topicName={topicName} field={kind.field} send={send} />;
    case "slider":
      return <Slider context={context} topicName={topicName} slider={kind} send={send} />;
    case "servos":
      return (
        <ServoSliders
          context={context}
          topicName={topicName}
          servos={kind}
          send={(message) => send(message, true)}
        />
      );
    case "text":
      return <TextLine field={kind.field} send={send} />;
    case "color":
      return <ColorPicker send={send} />;
    case "joints":
      return <JointSliders context={context} send={(message) => send(message, true)} />;
    case "drive":
      return (
        <button
          type="button"
          class="button primary push"
          onClick={() => context.open("drive", { topic: topicName })}
        >
          {texts.controls.drive}
        </button>
      );
    case "form":
      return <AnyForm type={type} send={send} />;
  }
}

export function PushButton({ send, label }: { send: (message: Draft) => unknown; label: string }) {
  const count = useSignal(0);
  return (
    <button
      type="button"
      class="button primary push"
      onClick={() => {
        send({});
        count.value++;
      }}
    >
      <span class="push-label">{label.replaceAll("_", " ")}</span>
      {count.value > 0 && <span class="push-count">{texts.controls.sent(count.value)}</span>}
    </button>
  );
}

/** A switch that follows other publishers of its topic, such as other pages. */
function TopicToggle(props: { context: PanelContext; topicName: string; field: string; send: Send }) {
  const { context, topicName, field, send } = props;
  const state = useSignal<boolean | undefined>(undefined);
  const noteSent = useOthersValue(context, topicName, (message) => {
    state.value = message[field] === true;
  });
  const sendAndNote = (message: Draft) => {
    noteSent();
    return send(message);
  };
  return <Toggle field={field} label={topicName} state={state} send={sendAndNote} />;
}

/** `send` returns whether the receiver has the new state; `state` is undefined until it is known. */
export function Toggle(props: {
  field: string;
  label: string;
  state: Signal<boolean | undefined>;
  send: (message: Draft) => boolean | Promise<boolean>;
}) {
  const { field, label, state, send } = props;
  const set = async (next: boolean) => {
    state.value = next;
    const isDone = await send({ [field]: next });
    if (!isDone && state.value === next) state.value = undefined;
  };
  const { on, off, unknown } = texts.controls;
  return (
    // biome-ignore lint/a11y/useSemanticElements: an input has no attribute for the state "mixed".
    <button
      type="button"
      role="checkbox"
      class="switch"
      aria-checked={state.value ?? "mixed"}
      aria-label={label}
      onClick={() => void set(!state.value)}
    >
      <span class="switch-knob" />
      <span>{state.value === undefined ? unknown : state.value ? on : off}</span>
    </button>
  );
}

function Slider(props: {
  context: PanelContext;
  topicName: string;
  slider: ControlKind & { kind: "slider" };
  send: Send;
}) {
  const { context, topicName, slider, send } = props;
  const settings = context.settings as Signal<ControlSettings>;
  const range = settings.value.ranges?.[topicName] ?? slider;
  const value = useSignal<number | bigint>(Math.min(Math.max(0, range.min), range.max));
  const noteSent = useOthersValue(context, topicName, (message) => {
    const next = message[slider.field];
    if (typeof next === "number" || typeof next === "bigint") value.value = next;
  });
  const set = (next: number | bigint, smoothly: boolean) => {
    value.value = next;
    noteSent();
    send({ [slider.field]: next }, smoothly);
  };
  const read = (input: HTMLInputElement) => {
    if (input.value === "") return;
    const next = parseNumber(slider.type, input.value);
    input.setCustomValidity(typeof next === "string" ? next : "");
    input.reportValidity();
    if (typeof next !== "string") set(next, false);
  };
  const setLimit = (limit: "min" | "max", text: string) => {
    const next = { min: range.min, max: range.max, [limit]: Number(text) };
    if (!(next.min < next.max)) return;
    settings.value = { ...settings.value, ranges: { ...settings.value.ranges, [topicName]: next } };
  };
  const limitField = (limit: "min" | "max") => (
    <input
      type="number"
      class="slider-limit"
      aria-label={limit === "min" ? texts.controls.lowest : texts.controls.highest}
      value={range[limit]}
      onChange={(event) => setLimit(limit, event.currentTarget.value)}
    />
  );
  const box = {
    class: "slider-value",
    "aria-label": texts.controls.value,
    value: shownNumber(slider.type, value.value),
    onChange: (event: TargetedEvent<HTMLInputElement>) => read(event.currentTarget),
  };
  return (
    <div class="slider">
      <input
        type="range"
        aria-label={topicName}
        min={range.min}
        max={range.max}
        step={slider.step}
        value={Number(value.value)}
        onInput={(event) => set(event.currentTarget.valueAsNumber, true)}
      />
      {limitField("min")}
      {/* A field of type "number" would round integers of 64 bits. */}
      {slider.type.endsWith("int64") ? (
        <input type="text" {...box} />
      ) : (
        <input type="number" step={slider.step} {...box} />
      )}
      {limitField("max")}
    </div>
  );
}

function TextLine({ field, send }: { field: string; send: Send }) {
  const text = useSignal("");
  return (
    <form
      class="text-line"
      onSubmit={(event) => {
        event.preventDefault();
        send({ [field]: text.value });
      }}
    >
      <input
        type="text"
        aria-label={field}
        placeholder={texts.controls.text}
        value={text.value}
        onInput={(event) => {
          text.value = event.currentTarget.value;
        }}
      />
      <button type="submit" class="button primary">
        {texts.controls.send}
      </button>
    </form>
  );
}

/** The text of a number; of a float32 without the additional digits of the float64 that stores it. */
function shownNumber(type: Primitive, value: number | bigint): string {
  return String(type === "float32" ? Number(Number(value).toPrecision(7)) : value);
}

function ColorPicker({ send }: { send: Send }) {
  const pick = (hex: string) => {
    const channel = (at: number) => Number.parseInt(hex.slice(at, at + 2), 16) / 255;
    send({ r: channel(1), g: channel(3), b: channel(5), a: 1 }, true);
  };
  return (
    <input
      type="color"
      class="color"
      aria-label={texts.controls.color}
      onInput={(event) => pick(event.currentTarget.value)}
    />
  );
}

function AnyForm({ type, send }: { type: StructNode; send: Send }) {
  const draft = useSignal<Draft>({});
  return (
    <form
      class="any-form"
      onSubmit={(event) => {
        event.preventDefault();
        send(draft.value);
      }}
    >
      <MessageForm
        type={type}
        draft={draft.value}
        onChange={(next) => {
          draft.value = next;
        }}
      />
      <button type="submit" class="button primary">
        {texts.controls.send}
      </button>
    </form>
  );
}

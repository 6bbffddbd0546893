// Drive a robot: stick, keys or gamepad. The gateway stops it when this page is closed.
import { type Signal, useComputed } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { EmptyState } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { graphOf } from "../graph_of.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { DEFAULT_LIMITS, LARGEST_LIMITS, type Limits } from "./commands.ts";
import { drivableTopics } from "./drivable.ts";
import type { Driver } from "./driver.ts";
import { driverOf } from "./drivers.ts";
import { followGamepad, followKeys } from "./inputs.ts";
import { StickPad } from "./stick.tsx";

interface DriveSettings {
  topic?: string;
  /** By topic. */
  limits?: Record<string, Limits>;
}

function DrivePanel({ context }: { context: PanelContext }) {
  const settings = context.settings as Signal<DriveSettings>;
  const { robot } = context;
  const topics = useComputed(() => drivableTopics(graphOf(robot))).value;
  const wanted = settings.value.topic ?? "";
  const topic = topics.includes(wanted) ? wanted : topics[0];
  if (topic === undefined)
    return <EmptyState icon="drive" title={texts.drive.none} text={texts.drive.noneText} />;
  const driver = driverOf(robot, topic);
  if (driver === undefined) return <p class="problem">{texts.drive.unknownType}</p>;
  return (
    <div class="drive">
      {!context.isCard && topics.length > 1 && (
        <div class="toolbar">
          <select
            aria-label={texts.drive.topic}
            value={topic}
            onChange={(event) => {
              settings.value = { ...settings.value, topic: event.currentTarget.value };
            }}
          >
            {topics.map((each) => (
              <option key={each} value={each}>
                {each}
              </option>
            ))}
          </select>
        </div>
      )}
      <Drive key={topic} driver={driver} topic={topic} settings={settings} context={context} />
    </div>
  );
}

function Drive(props: {
  driver: Driver;
  topic: string;
  settings: Signal<DriveSettings>;
  context: PanelContext;
}) {
  const { driver, topic, settings, context } = props;
  const limits = settings.value.limits?.[topic] ?? DEFAULT_LIMITS;
  driver.limits = limits;
  useEffect(() => {
    const ends = [followGamepad(driver)];
    // On the overview arrow keys scroll.
    if (!context.isCard) ends.push(followKeys(driver));
    return () => {
      for (const end of ends) end();
      driver.release();
    };
  }, [driver]);
  const set = (change: Partial<Limits>) => {
    settings.value = {
      ...settings.value,
      limits: { ...settings.value.limits, [topic]: { ...limits, ...change } },
    };
  };
  const lease = driver.lease.value;
  const isReadOnly = !context.robot.mayAct.value;
  const whyReadOnly = context.robot.canCommand.value ? texts.drive.viewOnly : texts.drive.notConnected;
  return (
    <fieldset class="drive-body" disabled={isReadOnly}>
      <p class={lease.state === "taken" ? "drive-state problem" : "drive-state"}>
        {isReadOnly
          ? whyReadOnly
          : lease.state === "taken"
            ? texts.drive.taken(lease.driver)
            : lease.state === "driving"
              ? texts.drive.driving(topic)
              : driver.isBlocked.value
                ? texts.drive.blocked
                : texts.drive.ready(topic)}
      </p>
      <StickPad driver={driver} />
      <div class="drive-limits">
        <Limit
          label={driver.hasTurnLimit ? texts.drive.linear : texts.drive.share}
          value={driver.hasTurnLimit ? limits.linear : Math.min(limits.linear, 1)}
          max={driver.hasTurnLimit ? LARGEST_LIMITS.linear : 1}
          onChange={(linear) => set({ linear })}
        />
        {driver.hasTurnLimit && (
          <Limit
            label={texts.drive.angular}
            value={limits.angular}
            max={LARGEST_LIMITS.angular}
            onChange={(angular) => set({ angular })}
          />
        )}
      </div>
      {!context.isCard && (
        <p class="drive-hint">
          {matchMedia("(pointer: coarse)").matches ? texts.drive.hintTouch : texts.drive.hint}
        </p>
      )}
    </fieldset>
  );
}

function Limit(props: { label: string; value: number; max: number; onChange: (value: number) => void }) {
  return (
    <label class="drive-limit">
      <span>{props.label}</span>
      <input
        type="range"
        min={0.05}
        max={props.max}
        step={0.05}
        value={props.value}
        onInput={(event) => props.onChange(event.currentTarget.valueAsNumber)}
      />
      <span class="number">{props.value.toFixed(2)}</span>
    </label>
  );
}

export default preactPanel(DrivePanel);

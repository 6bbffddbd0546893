// Simulated boards: live pins, servos, and their surroundings.
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { EmptyState } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { TopicPublisher } from "../controls/topic_publisher.ts";
import { useFeed } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { BoardDrawing } from "./board_drawing.tsx";
import { type BoardState, isNumbered, type Pin, readBoardState, simulatedBoards } from "./board_state.ts";

const t = texts.simulation;
const MAX_RANGE_M = 4;
const DEFAULT_RANGE_M = 1;
const FULL_BATTERY_V = 12;
const MAX_BATTERY_V = 18;
const SETTLE_MS = 500;
const FAULTS = ["none", "flip=0.0001", "flip=0.001", "flip=0.01", "drop=0.001", "drop=0.01"];

type SendLine = (line: string) => void;

function SimulationPanel({ context }: { context: PanelContext }) {
  const boards = simulatedBoards(context.robot.topics.value.values());
  if (boards.size === 0)
    return <EmptyState icon="simulation" title={t.none} text={t.noneText} command={t.noneCommand} />;
  const { topic: shown } = context.settings.value;
  // A card shows one board, without its surroundings.
  if (context.isCard) {
    return <Board context={context} topic={String(shown)} name={boards.get(String(shown)) ?? ""} />;
  }
  return (
    <div class="simulation">
      {[...boards].map(([topic, name]) => (
        <Board key={topic} context={context} topic={topic} name={name} />
      ))}
    </div>
  );
}

function Board({ context, topic, name }: { context: PanelContext; topic: string; name: string }) {
  const { robot } = context;
  const feed = useFeed(context, topic);
  const text = feed.lastValid()?.data;
  const state = useMemo(() => readBoardState(text), [text]);
  const commands = robot.topics.value.get(topic.replace(/state$/, "command"));
  const publisher = useSignal<TopicPublisher | undefined>(undefined);
  const mayAct = robot.mayAct.value && commands !== undefined;
  useEffect(() => {
    if (!mayAct) return;
    const made = new TopicPublisher(robot, commands);
    publisher.value = made;
    return () => {
      publisher.value = undefined;
      made.dispose();
    };
  }, [mayAct, commands?.definition]);
  const send: SendLine = (line) => publisher.peek()?.publish({ data: line });
  const tapped = useRef(new Map<string, { isDriven: boolean; untilMs: number }>());
  // The first tap drives a pin to its other level, as a button does; the second releases it.
  const tap = ({ name, level }: Pin) => {
    const now = performance.now();
    const last = tapped.current.get(name);
    // The board's last state may be older than the last tap.
    const isDriven = last && now < last.untilMs ? last.isDriven : state?.driven[name] !== undefined;
    tapped.current.set(name, { isDriven: !isDriven, untilMs: now + SETTLE_MS });
    send(`pin ${name}=${isDriven ? "z" : level > 0 ? 0 : 1}`);
  };
  const slide: SendLine = (line) => publisher.peek()?.publishSmoothly({ data: line });
  // The pins of the drawing are smaller than a finger.
  const isTouchScreen = !context.isCard && matchMedia("(pointer: coarse)").matches;
  const drawing = state && (
    <div>
      <BoardDrawing state={state} isDisabled={!mayAct} tap={tap} />
      <NamedPins
        pins={state.pins.filter((pin) => !isNumbered(pin.name) || (isTouchScreen && isPressable(pin, state)))}
        driven={state.driven}
        isDisabled={!mayAct}
        tap={tap}
      />
      <p class="simulation-hint">{t.hint}</p>
    </div>
  );
  if (context.isCard) return drawing ?? <p class="empty-line">{t.waiting}</p>;
  return (
    <section class="control-card simulation-board" aria-label={name}>
      <h2>
        {name} <span class="simulation-kind">{state && `${state.board}, ${state.mcu}`}</span>
      </h2>
      {state ? (
        <div class="simulation-parts">
          {drawing}
          <fieldset class="simulation-surroundings" disabled={!mayAct}>
            <Obstacle state={state} send={send} slide={slide} />
            <Battery state={state} slide={slide} />
            <Volts state={state} slide={slide} />
            <Line state={state} send={send} />
          </fieldset>
          {state.error && <p class="problem">{state.error}</p>}
        </div>
      ) : (
        <p class="empty-line">{t.waiting}</p>
      )}
    </section>
  );
}

/** Whether the pin can be driven from outside, or is driven now. */
function isPressable({ name, direction }: Pin, { driven }: BoardState): boolean {
  return direction === "in" || driven[name] !== undefined;
}

/** Pins as buttons: those with names, such as the LEDs of an OpenCR; on touch screens, the numbered inputs too. */
function NamedPins(props: {
  pins: readonly Pin[];
  driven: Readonly<Record<string, number>>;
  isDisabled: boolean;
  tap: (pin: Pin) => void;
}) {
  const { pins, driven, isDisabled, tap } = props;
  if (pins.length === 0) return null;
  return (
    <ul class="simulation-pins">
      {pins.map((pin) => {
        const { name, direction, level } = pin;
        return (
          <li key={name}>
            <button
              type="button"
              class={level > 0 ? "button simulation-high" : "button"}
              aria-label={t.pin(name, direction, level)}
              aria-pressed={driven[name] !== undefined}
              data-pin={name}
              data-level={level}
              disabled={isDisabled || direction !== "in"}
              onClick={() => tap(pin)}
            >
              {name}
            </button>
          </li>
        );
      })}
    </ul>
  );
}

function Obstacle({ state, send, slide }: { state: BoardState; send: SendLine; slide: SendLine }) {
  const meters = Number.parseFloat(state.values.range ?? "");
  const isThere = Number.isFinite(meters);
  return (
    <div class="simulation-row">
      <label class="check">
        <input
          type="checkbox"
          checked={isThere}
          onChange={(event) => send(`range ${event.currentTarget.checked ? DEFAULT_RANGE_M : "none"}`)}
        />
        {t.obstacle}
      </label>
      <Slider
        label={t.obstacle}
        min={0.02}
        max={MAX_RANGE_M}
        value={isThere ? meters : DEFAULT_RANGE_M}
        onSlide={(value) => slide(`range ${value}`)}
      />
      <span class="number">{isThere ? `${meters.toFixed(2)} m` : "–"}</span>
    </div>
  );
}

function Battery({ state, slide }: { state: BoardState; slide: SendLine }) {
  if (!state.commands.includes("battery")) return null;
  const volts = Number.parseFloat(state.values.battery ?? "") || FULL_BATTERY_V;
  return (
    <div class="simulation-row">
      <span>{t.battery}</span>
      <Slider
        label={t.battery}
        min={0}
        max={MAX_BATTERY_V}
        value={volts}
        onSlide={(value) => slide(`battery ${value}`)}
      />
      <span class="number">{volts.toFixed(2)} V</span>
    </div>
  );
}

function Volts({ state, slide }: { state: BoardState; slide: SendLine }) {
  const inputs = state.pins.filter(({ name }) => /^A[0-5]$/.test(name)).map(({ name }) => name);
  return (
    <>
      {inputs.map((pin) => (
        <div class="simulation-row" key={pin}>
          <span>{pin}</span>
          <Slider
            label={t.volts(pin)}
            min={0}
            max={state.maxVolts}
            value={state.volts[pin] ?? 0}
            onSlide={(value) => slide(`adc ${pin}=${value}`)}
          />
          <span class="number">{(state.volts[pin] ?? 0).toFixed(2)} V</span>
        </div>
      ))}
    </>
  );
}

function Slider(props: {
  label: string;
  min: number;
  max: number;
  value: number;
  onSlide: (value: number) => void;
}) {
  // While the user moves the slider, the board's last report is older than the position of the slider.
  const own = useSignal<number | undefined>(undefined);
  return (
    <input
      type="range"
      aria-label={props.label}
      min={props.min}
      max={props.max}
      step={0.01}
      value={own.value ?? props.value}
      onInput={(event) => {
        own.value = event.currentTarget.valueAsNumber;
        props.onSlide(own.value);
      }}
      onChange={() => {
        setTimeout(() => {
          own.value = undefined;
        }, SETTLE_MS);
      }}
    />
  );
}

function Line({ state, send }: { state: BoardState; send: SendLine }) {
  const fault = state.values.fault ?? "none";
  const isOff = state.values.power === "off";
  const has = (word: string) => state.commands.includes(word);
  const choices = FAULTS.includes(fault) ? FAULTS : [...FAULTS, fault];
  return (
    <div class="simulation-row wraps">
      {has("fault") && (
        <label>
          {t.faults}{" "}
          <select value={fault} onChange={(event) => send(`fault ${event.currentTarget.value}`)}>
            {choices.map((each) => (
              <option key={each} value={each}>
                {t.fault(each)}
              </option>
            ))}
          </select>
        </label>
      )}
      <div class="simulation-buttons">
        {has("reset") && (
          <button type="button" class="button" onClick={() => send("reset")}>
            {t.reset}
          </button>
        )}
        {has("power") && (
          <button type="button" class="button" onClick={() => send(`power ${isOff ? "on" : "off"}`)}>
            {isOff ? t.powerOn : t.powerOff}
          </button>
        )}
      </div>
    </div>
  );
}

export default preactPanel(SimulationPanel);

// A board seen from above: USB, chip, LED, pins with their levels, servos. Some boards have more pins than an Uno.
import { texts } from "../../texts.ts";
import type { BoardState, Pin } from "./board_state.ts";

const PITCH = 34;
const PER_ROW = 14;
const MARGIN = 56;
const ROW = 52;
const MIDDLE = 150;
const t = texts.simulation;

interface Drawn {
  state: BoardState;
  isDisabled: boolean;
  /** Drives a pin from outside, or releases it. */
  tap: (pin: Pin) => void;
}

export function BoardDrawing(props: Drawn) {
  const { pins, servos, board, mcu } = props.state;
  // As printed on boards: digital pins above, from the highest to D0; analog ones below.
  const digital = pins.filter(({ name }) => /^D\d/.test(name)).reverse();
  const analog = pins.filter(({ name }) => /^A\d/.test(name));
  const above = inRows(digital);
  const below = inRows(analog);
  const width = MARGIN * 2 + PITCH * PER_ROW;
  const middle = 14 + above.length * ROW;
  const height = middle + MIDDLE + below.length * ROW + 8;
  const led = pins.find(({ name }) => name === "D13");
  const angles = Object.entries(servos);
  return (
    // biome-ignore lint/a11y/useSemanticElements: a drawing has no field sets
    <svg class="simulation-drawing" viewBox={`0 0 ${width} ${height}`} role="group" aria-label={t.pins}>
      <rect class="pcb" x="12" y="2" width={width - 24} height={height - 4} rx="14" />
      <rect class="usb" x="0" y={middle + 20} width="74" height="64" rx="4" />
      <rect class="chip" x="250" y={middle + 62} width="210" height="52" rx="4" />
      <text class="chip-name" x="355" y={middle + 93}>
        {mcu}
      </text>
      <text class="board-name" x="96" y={middle + 112}>
        {board}
      </text>
      {led && <Led level={led.direction === "in" ? 0 : led.level} x={120} y={middle + 40} />}
      {angles.slice(0, 6).map(([pin, degrees], i) => (
        <Servo key={pin} pin={pin} degrees={degrees} x={210 + i * 60} y={middle + 28} />
      ))}
      {above.map((row, y) =>
        row.map((pin, x) => <PinView key={pin.name} {...props} pin={pin} x={x} y={14 + y * ROW} />),
      )}
      {below.map((row, y) =>
        row.map((pin, x) => (
          <PinView key={pin.name} {...props} pin={pin} x={x} y={middle + MIDDLE + y * ROW} />
        )),
      )}
    </svg>
  );
}

function inRows(pins: Pin[]): Pin[][] {
  const rows: Pin[][] = [];
  for (let first = 0; first < pins.length; first += PER_ROW) rows.push(pins.slice(first, first + PER_ROW));
  return rows;
}

function PinView({ pin, state, isDisabled, tap, x, y }: Drawn & { pin: Pin; x: number; y: number }) {
  const { name, direction, level } = pin;
  const driven = state.driven[name];
  const left = MARGIN + x * PITCH;
  const press = () => {
    if (!isDisabled) tap(pin);
  };
  return (
    // biome-ignore lint/a11y/useSemanticElements: a drawing has no buttons
    <g
      class={`pin ${direction} ${driven === undefined ? "" : "driven"}`}
      role="button"
      tabindex={isDisabled ? -1 : 0}
      aria-label={t.pin(name, direction, level)}
      aria-pressed={driven !== undefined}
      data-pin={name}
      data-level={level}
      onClick={press}
      onKeyDown={(event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        press();
      }}
    >
      <title>{t.pin(name, direction, level)}</title>
      <rect class="hole" x={left} y={y} width={PITCH - 6} height={PITCH - 6} rx="4" />
      <rect
        class="level"
        x={left}
        y={y + (PITCH - 6) * (1 - level)}
        width={PITCH - 6}
        height={(PITCH - 6) * level}
        rx="4"
      />
      <text x={left + (PITCH - 6) / 2} y={y + PITCH + 9}>
        {name.replace(/^D/, "")}
      </text>
    </g>
  );
}

function Led({ level, x, y }: { level: number; x: number; y: number }) {
  return (
    <g>
      <circle class="led" cx={x} cy={y} r="9" />
      <circle class="led-light" cx={x} cy={y} r="9" opacity={level} />
      <text class="led-name" x={x} y={y + 26}>
        L
      </text>
    </g>
  );
}

function Servo({ pin, degrees, x, y }: { pin: string; degrees: number; x: number; y: number }) {
  return (
    <g class="servo">
      <title>{t.servo(pin, degrees)}</title>
      <circle cx={x} cy={y} r="20" />
      <line x1={x} y1={y} x2={x} y2={y - 17} transform={`rotate(${90 - degrees} ${x} ${y})`} />
      <text x={x} y={y + 36}>{`${pin} ${Math.round(degrees)}°`}</text>
    </g>
  );
}

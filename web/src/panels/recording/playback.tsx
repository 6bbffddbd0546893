// Controls of the playback: time line, pause, speed, and the names of the topics.
import { useSignal } from "@preact/signals";
import type { Playing } from "../../connection/protocol.ts";
import { formatDuration } from "../../shell/format.ts";
import { IconButton } from "../../shell/parts.tsx";
import type { Robot } from "../../store/robot.ts";
import { texts } from "../../texts.ts";

const RATES = [0.25, 0.5, 1, 2, 5];
const t = texts.recording;

export function Playback({ robot, playing }: { robot: Robot; playing: Playing }) {
  // While the time line is moved, the robot's last report is older than the position of the slider.
  const wanted = useSignal<number | undefined>(undefined);
  const { name, seconds, length, rate, paused, prefix } = playing;
  const play = (start: number, speed: number, prefixed: boolean) =>
    robot.gateway.playRecording(name, start, speed, prefixed);
  const isPrefixed = prefix !== "";
  return (
    <section class="control-card recording-playback" aria-label={t.playing(name)}>
      <h2>{t.playing(name)}</h2>
      <input
        type="range"
        aria-label={t.timeLine}
        min={0}
        max={length}
        step={0.1}
        value={wanted.value ?? seconds}
        disabled={!robot.mayAct.value}
        onInput={(event) => {
          wanted.value = event.currentTarget.valueAsNumber;
        }}
        onChange={(event) => {
          wanted.value = undefined;
          play(event.currentTarget.valueAsNumber, rate, isPrefixed);
        }}
      />
      <div class="toolbar">
        <IconButton
          icon={paused ? "play" : "pause"}
          label={paused ? t.continue : t.pause}
          isDisabled={!robot.mayAct.value}
          onClick={() => robot.gateway.pausePlayback(!paused)}
        />
        <IconButton
          icon="stop"
          label={t.end}
          isDisabled={!robot.mayAct.value}
          onClick={() => robot.gateway.stopPlayback()}
        />
        <span class="number">{`${formatDuration(wanted.value ?? seconds)} / ${formatDuration(length)}`}</span>
        <span class="spring" />
        <select
          aria-label={t.rate}
          value={rate}
          onChange={(event) => play(seconds, Number(event.currentTarget.value), isPrefixed)}
        >
          {(RATES.includes(rate) ? RATES : [...RATES, rate]).map((each) => (
            <option key={each} value={each}>
              {`${each} x`}
            </option>
          ))}
        </select>
        <label>
          <input
            type="checkbox"
            checked={!isPrefixed}
            onChange={(event) => play(seconds, rate, !event.currentTarget.checked)}
          />{" "}
          {t.ownNames}
        </label>
      </div>
      <p class="muted">{isPrefixed ? t.prefixed(prefix) : t.live}</p>
    </section>
  );
}

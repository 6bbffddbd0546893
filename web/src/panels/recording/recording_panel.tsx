// Record on the robot, and download recordings.
import { type Signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { recordingUrl } from "../../connection/address.ts";
import { formatBytes, formatDuration } from "../../shell/format.ts";
import { Icon } from "../../shell/icons.tsx";
import { EmptyState, IconButton } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { Playback } from "./playback.tsx";

type Format = "bag" | "mcap";

function RecordingPanel({ context }: { context: PanelContext }) {
  const { robot } = context;
  const isOffered = robot.info.value?.metadata?.features?.split(",").includes("record") ?? false;
  const canCommand = robot.canCommand.value;
  useEffect(() => {
    if (isOffered && canCommand) robot.gateway.followRecordings();
  }, [isOffered, canCommand]);
  const chosen = useSignal<Format | undefined>(undefined);
  // A graph with only ROS 2 does not need bags of ROS 1.
  const preferred = robot.info.value?.metadata?.recording_format === "mcap" ? "mcap" : "bag";
  if (!isOffered)
    return (
      <EmptyState icon="recording" title={texts.recording.notOffered} text={texts.recording.notOfferedText} />
    );
  const state = robot.recordings.value;
  if (state === undefined) return null;
  return (
    <div class="recording">
      <section class="control-card recording-now">
        <StartStop context={context} chosen={chosen} preferred={preferred} />
        <p class={state.active ? "recording-state active" : "recording-state"}>
          {state.active
            ? texts.recording.active(
                state.active.name,
                formatDuration(state.active.seconds),
                state.active.messages,
                state.active.topics,
                formatBytes(state.active.bytes),
              )
            : texts.recording.idle}
        </p>
        {state.error && <p class="problem">{state.error}</p>}
      </section>
      {state.playing && <Playback robot={robot} playing={state.playing} />}
      <h2>{texts.recording.files}</h2>
      {state.files.length === 0 ? (
        <EmptyState icon="recording" title={texts.recording.none} text={texts.recording.noneText} />
      ) : (
        <ul class="recording-files">
          {state.files.map(({ name, bytes, time }) => (
            <li key={name}>
              <span class="recording-name">{name}</span>
              <span class="number">{formatBytes(bytes)}</span>
              <time class="number">{new Date(time * 1000).toLocaleString()}</time>
              <IconButton
                icon="play"
                label={texts.recording.play(name)}
                isDisabled={!robot.mayAct.value}
                onClick={() => robot.gateway.playRecording(name, 0, 1, true)}
              />
              <a
                class="icon-button"
                href={recordingUrl(name)}
                download={name}
                title={texts.recording.download(name)}
                aria-label={texts.recording.download(name)}
              >
                <Icon name="download" />
              </a>
            </li>
          ))}
        </ul>
      )}
      <p class="muted">{texts.recording.folder(state.folder)}</p>
    </div>
  );
}

function StartStop(props: { context: PanelContext; chosen: Signal<Format | undefined>; preferred: Format }) {
  const { chosen, preferred } = props;
  const { robot } = props.context;
  const format = chosen.value ?? preferred;
  const formats: Format[] = preferred === "bag" ? ["bag", "mcap"] : ["mcap", "bag"];
  const isActive = robot.recordings.value?.active != null;
  const toggle = () => {
    if (isActive) robot.gateway.stopRecording();
    else robot.gateway.startRecording([], format);
  };
  return (
    <div class="toolbar">
      <button
        type="button"
        class={isActive ? "button" : "button primary"}
        disabled={!robot.mayAct.value}
        onClick={toggle}
      >
        {isActive ? texts.recording.stop : texts.recording.start}
      </button>
      {!isActive && (
        <select
          aria-label={texts.recording.format}
          value={format}
          onChange={(event) => {
            chosen.value = event.currentTarget.value as Format;
          }}
        >
          {formats.map((each) => (
            <option key={each} value={each}>
              {each === "mcap" && preferred === "mcap" ? texts.recording.mcapRos2 : texts.recording[each]}
            </option>
          ))}
        </select>
      )}
    </div>
  );
}

export default preactPanel(RecordingPanel);

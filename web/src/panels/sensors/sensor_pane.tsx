// One sensor: a picture, a number with its unit and history, or the message in one line.
import { useSignal } from "@preact/signals";
import { useMemo, useRef } from "preact/hooks";
import { formatFixed, formatRate } from "../../shell/format.ts";
import { IconButton } from "../../shell/parts.tsx";
import { Sparkline } from "../../shell/sparkline.tsx";
import { texts } from "../../texts.ts";
import { pathReader } from "../../wire/path.ts";
import { useFeed, useTick } from "../hooks.ts";
import type { Turn } from "../images/image_view.ts";
import { Picture } from "../images/picture.tsx";
import { IMAGE_TYPES } from "../images/types.ts";
import type { PanelContext } from "../panel.ts";
import { mainPaths } from "../plots/suggestions.ts";
import { brief } from "../topics/brief.ts";
import type { Sensor } from "./sensor_tree.ts";

const HISTORY_LENGTH = 240;
const REFRESH_MS = 500;

const t = texts.sensors;

export function SensorPane({ context, sensor }: { context: PanelContext; sensor: Sensor }) {
  const turn = useSignal<Turn | undefined>(undefined);
  const typeName = context.robot.topics.value.get(sensor.topic)?.typeName ?? sensor.message_type;
  if (IMAGE_TYPES.includes(typeName))
    return (
      <Picture
        context={context}
        topic={sensor.topic}
        turn={turn.value}
        onTurn={(to) => {
          turn.value = to;
        }}
      />
    );
  return <ValuePane context={context} sensor={sensor} />;
}

function ValuePane({ context, sensor }: { context: PanelContext; sensor: Sensor }) {
  const history = useMemo((): number[] => [], [sensor.topic]);
  const topic = context.robot.topics.value.get(sensor.topic);
  const path = useMemo(() => (topic ? mainPaths(topic)[0] : undefined), [topic]);
  const reader = useMemo(() => (topic && path ? pathReader(topic.type(), path) : undefined), [topic, path]);
  const readerNow = useRef(reader);
  readerNow.current = reader;
  const feed = useFeed(context, sensor.topic, ({ payload }) => {
    if (readerNow.current) history.push(readerNow.current.read(payload));
    if (history.length > HISTORY_LENGTH) history.shift();
  });
  const nowMs = useTick(context, REFRESH_MS);
  const message = feed.lastMessage();
  if (message === undefined) return <p class="empty-line">{sensor.state_text || t.waiting(sensor.topic)}</p>;
  if (message instanceof Error) return <p class="problem">{message.message}</p>;
  return (
    <div class={feed.isStale(nowMs) ? "sensor-value is-stale" : "sensor-value"}>
      {reader === undefined ? (
        <p class="sensor-text">{brief(message)}</p>
      ) : (
        <>
          <p class="sensor-number">
            {formatFixed(reader.read(feed.last!.payload))}{" "}
            {sensor.unit && <span class="sensor-unit">{sensor.unit}</span>}
          </p>
          <Sparkline values={history} length={HISTORY_LENGTH} />
        </>
      )}
      <p class="sensor-foot">
        <span class="sensor-topic">{sensor.topic}</span>
        <span>{formatRate(feed.rate.hertz(nowMs))}</span>
        {path !== undefined && (
          <IconButton
            icon="plots"
            label={texts.topics.plot}
            onClick={() => context.open("plots", { add: `${sensor.topic}.${path}` })}
          />
        )}
      </p>
      {sensor.state_text && <p class="problem">{sensor.state_text}</p>}
    </div>
  );
}

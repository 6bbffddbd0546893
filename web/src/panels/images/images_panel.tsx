// Pictures: compressed and raw, with rate and age, turned and mirrored as the camera hangs.
import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { formatDuration, formatRate } from "../../shell/format.ts";
import { EmptyState, IconButton } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { ImageView, type Turn } from "./image_view.ts";
import { IMAGE_TYPES } from "./types.ts";

interface ImageSettings {
  topic?: string;
  /** By topic. */
  turns?: Record<string, Turn>;
}

function ImagesPanel({ context }: { context: PanelContext }) {
  const settings = context.settings as Signal<ImageSettings>;
  const topics = [...context.robot.topics.value.values()]
    .filter((topic) => IMAGE_TYPES.includes(topic.typeName) && topic.channelId !== undefined)
    .map((topic) => topic.name)
    .sort();
  const chosen = settings.value.topic ?? "";
  const shown = context.isCard || chosen !== "" ? [chosen] : topics;
  if (!context.isCard && topics.length === 0)
    return <EmptyState icon="images" title={texts.images.empty} text={texts.images.emptyText} />;
  return (
    <div class="images">
      {!context.isCard && (
        <div class="toolbar">
          <label>
            {texts.images.topic}{" "}
            <select
              value={chosen}
              onChange={(event) => {
                settings.value = { ...settings.value, topic: event.currentTarget.value };
              }}
            >
              <option value="">{texts.images.all}</option>
              {topics.map((topic) => (
                <option key={topic} value={topic}>
                  {topic}
                </option>
              ))}
            </select>
          </label>
        </div>
      )}
      <div class={shown.length > 1 ? "images-grid" : "images-one"}>
        {shown.map((topic) => (
          <Picture key={topic} context={context} topic={topic} settings={settings} />
        ))}
      </div>
    </div>
  );
}

function Picture(props: { context: PanelContext; topic: string; settings: Signal<ImageSettings> }) {
  const { context, topic, settings } = props;
  const host = useRef<HTMLDivElement>(null);
  const view = useRef<ImageView | undefined>(undefined);
  const problem = useSignal("");
  const feed = context.robot.feed(topic);
  const now = useTick(context, 500);
  useEffect(() => {
    const made = new ImageView(feed, (text) => {
      problem.value = text;
    });
    view.current = made;
    (host.current as HTMLDivElement).append(made.canvas);
    const { close } = context.subscribe(topic, () => made.update());
    if (feed.last !== undefined) made.update();
    return () => {
      close();
      made.dispose();
    };
  }, [topic]);
  const turn = settings.value.turns?.[topic] ?? { quarters: 0, mirrored: false };
  useEffect(() => {
    if (view.current === undefined) return;
    view.current.turn = turn;
    view.current.redraw();
  }, [turn.quarters, turn.mirrored]);
  const change = (to: Turn) => {
    settings.value = { ...settings.value, turns: { ...settings.value.turns, [topic]: to } };
  };
  const ageS = (now - feed.rate.lastMs) / 1000;
  const stale = feed.isStale(now);
  return (
    <figure class={stale ? "picture stale" : "picture"}>
      <div class="picture-canvas" ref={host}>
        {feed.last === undefined && <p class="empty-line">{texts.images.waiting(topic)}</p>}
      </div>
      <figcaption>
        <span class="picture-topic">{topic}</span>
        <span class="number">{formatRate(feed.rate.hertz(now))}</span>
        {stale && Number.isFinite(ageS) && (
          <span class="number">{texts.images.age(formatDuration(ageS))}</span>
        )}
        <IconButton
          icon="rotate"
          label={texts.images.rotate}
          onClick={() => change({ ...turn, quarters: (turn.quarters + 1) % 4 })}
        />
        <IconButton
          icon="flip"
          label={texts.images.mirror}
          isPressed={turn.mirrored}
          onClick={() => change({ ...turn, mirrored: !turn.mirrored })}
        />
      </figcaption>
      {problem.value && <p class="problem">{problem.value}</p>}
    </figure>
  );
}

export default preactPanel(ImagesPanel);

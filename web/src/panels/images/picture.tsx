// The image of one topic: compressed or raw, with rate and age, rotated and mirrored as the user chooses.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { formatDuration, formatRate } from "../../shell/format.ts";
import { IconButton } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { ImageView, type Turn } from "./image_view.ts";

const UPRIGHT: Turn = { quarters: 0, mirrored: false };

export function Picture(props: {
  context: PanelContext;
  topic: string;
  turn: Turn | undefined;
  onTurn: (turn: Turn) => void;
}) {
  const { context, topic, turn = UPRIGHT, onTurn } = props;
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
  useEffect(() => {
    if (view.current === undefined) return;
    view.current.turn = turn;
    view.current.redraw();
  }, [turn.quarters, turn.mirrored]);
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
          onClick={() => onTurn({ ...turn, quarters: (turn.quarters + 1) % 4 })}
        />
        <IconButton
          icon="flip"
          label={texts.images.mirror}
          isPressed={turn.mirrored}
          onClick={() => onTurn({ ...turn, mirrored: !turn.mirrored })}
        />
      </figcaption>
      {problem.value && <p class="problem">{problem.value}</p>}
    </figure>
  );
}

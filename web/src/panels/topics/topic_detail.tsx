// One topic: its publishers and subscribers, its messages as a tree, its definition.
import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { formatBandwidth, formatDuration, formatRate } from "../../shell/format.ts";
import { CopyButton, EmptyState, IconButton } from "../../shell/parts.tsx";
import { shellWord } from "../../shell/shell_word.ts";
import { texts } from "../../texts.ts";
import type { Message } from "../../wire/decode.ts";
import { useSubscription, useTick } from "../hooks.ts";
import type { PanelContext } from "../panel.ts";
import { MessageTree } from "./message_tree.tsx";

// A faster rate is not readable.
const REFRESH_MS = 200;

export function TopicDetail(props: { context: PanelContext; topicName: string; onClose: () => void }) {
  const { context, topicName } = props;
  const { robot } = context;
  const feed = robot.feed(topicName);
  const topic = feed.topic.value;
  const isPaused = useSignal(false);
  const kept = useRef<Message | Error | undefined>(undefined);
  useSubscription(context, topicName);
  const now = useTick(context, REFRESH_MS);
  if (!isPaused.value) kept.current = feed.lastMessage();
  const message = kept.current;
  const isStale = feed.last !== undefined && feed.isStale(now);
  const names = (nodes: readonly string[] | undefined) =>
    nodes && nodes.length > 0 ? nodes.join(", ") : "–";
  return (
    <aside class="topics-detail" aria-label={topicName}>
      <div class="topics-detail-head">
        <h2>{topicName}</h2>
        <CopyButton text={`rostether topic echo ${shellWord(topicName)}`} />
        <IconButton
          icon={isPaused.value ? "play" : "pause"}
          label={isPaused.value ? texts.topics.resume : texts.topics.pause}
          isPressed={isPaused.value}
          onClick={() => {
            isPaused.value = !isPaused.value;
          }}
        />
        <IconButton icon="close" label={texts.topics.close} onClick={props.onClose} />
      </div>
      <div class="topics-detail-body">
        <dl class="topics-facts">
          <dt>{texts.topics.type}</dt>
          <dd>{topic?.typeName ?? "–"}</dd>
          <dt>{texts.topics.rate}</dt>
          <dd class={isStale ? "stale" : undefined}>
            {formatRate(feed.rate.hertz(now))}
            {isStale && `, ${texts.units.ago(formatDuration((now - feed.rate.lastMs) / 1000))}`}
          </dd>
          <dt>{texts.topics.bandwidth}</dt>
          <dd>{formatBandwidth(feed.rate.bytesPerSecond(now))}</dd>
          <dt>{texts.topics.publishers}</dt>
          <dd>{names(robot.publishers.value.get(topicName))}</dd>
          <dt>{texts.topics.subscribers}</dt>
          <dd>{names(robot.subscribers.value.get(topicName))}</dd>
        </dl>
        {message === undefined ? (
          <EmptyState icon="topics" title={topic ? texts.topics.waiting : texts.topics.subscribedOnly} />
        ) : message instanceof Error ? (
          <p class="badge error">
            {texts.topics.unreadable}: {message.message}
          </p>
        ) : (
          <div class={isStale ? "stale" : undefined}>
            <MessageTree
              message={message}
              onPlot={(path) => context.open("plots", { add: `${topicName}.${path}` })}
            />
          </div>
        )}
        {topic && (
          <details class="topics-definition">
            <summary>{texts.topics.definition}</summary>
            <pre>{topic.definition.split(/^={40,}$/m)[0]!.trim()}</pre>
          </details>
        )}
      </div>
    </aside>
  );
}

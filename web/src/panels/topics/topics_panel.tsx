// All topics with rates and last values, and the messages of a chosen one.
import { useComputed } from "@preact/signals";
import { useMemo, useRef } from "preact/hooks";
import { compareNames, formatBandwidth, formatRate } from "../../shell/format.ts";
import { breakable, EmptyState, SearchField } from "../../shell/parts.tsx";
import { isHidden } from "../../store/topics.ts";
import { texts } from "../../texts.ts";
import { useTick } from "../hooks.ts";
import { MAIN_FIELDS } from "../main_fields.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { brief } from "./brief.ts";
import { useRowSubscriptions } from "./row_subscriptions.ts";
import { TopicDetail } from "./topic_detail.tsx";

const REFRESH_MS = 500;

interface Row {
  name: string;
  typeName: string;
  /** Whether a node publishes the topic. */
  isPublished: boolean;
}

function TopicsPanel({ context }: { context: PanelContext }) {
  const { robot, settings } = context;
  const search = String(settings.value.search ?? "");
  const chosen = settings.value.topic === undefined ? undefined : String(settings.value.topic);
  const change = (changes: object) => {
    settings.value = { ...settings.value, ...changes };
  };
  const rows = useComputed(() => allRows(context)).value;
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const withHidden = search.includes("_");
  const shown = rows.filter(({ name, typeName }) => {
    if (!withHidden && isHidden(name)) return false;
    const text = `${name} ${typeName}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
  const scroll = useRef<HTMLDivElement>(null);
  if (rows.length === 0 && robot.connection.value === "open") {
    return <EmptyState icon="topics" title={texts.topics.none} text={texts.topics.noneText} />;
  }
  return (
    <div class={chosen ? "topics with-detail" : "topics"}>
      <div class="topics-list">
        <div class="topics-search">
          <SearchField
            value={search}
            label={texts.topics.search}
            onInput={(text) => change({ search: text })}
          />
        </div>
        <div class="topics-scroll" ref={scroll}>
          {shown.length === 0 && rows.length > 0 ? (
            <EmptyState icon="search" title={texts.topics.noMatch} />
          ) : (
            <TopicTable
              context={context}
              rows={shown}
              chosen={chosen}
              scroll={scroll}
              onChoose={(topic) => change({ topic })}
            />
          )}
        </div>
      </div>
      {chosen && (
        <TopicDetail
          key={chosen}
          context={context}
          topicName={chosen}
          onClose={() => change({ topic: undefined })}
        />
      )}
    </div>
  );
}

function allRows({ robot }: PanelContext): Row[] {
  const topics = robot.topics.value;
  const names = new Set([
    ...topics.keys(),
    ...robot.subscribers.value.keys(),
    ...robot.publishers.value.keys(),
  ]);
  return [...names].sort(compareNames).map((name) => ({
    name,
    typeName: topics.get(name)?.typeName ?? "",
    isPublished: topics.get(name)?.isPublished ?? false,
  }));
}

interface TableProps {
  context: PanelContext;
  rows: Row[];
  chosen: string | undefined;
  scroll: { current: HTMLDivElement | null };
  onChoose: (topic: string) => void;
}

function TopicTable({ context, rows, chosen, scroll, onChoose }: TableProps) {
  const body = useRowSubscriptions(context, scroll, rows);
  const nowMs = useTick(context, REFRESH_MS);
  return (
    <table class="topics-table">
      <thead>
        <tr>
          <th>{texts.topics.topic}</th>
          <th class="wide">{texts.topics.type}</th>
          <th class="number wide" title={texts.topics.nodesTitle}>
            {texts.topics.nodes}
          </th>
          <th class="number">{texts.topics.rate}</th>
          <th class="number wide">{texts.topics.bandwidth}</th>
          <th>{texts.topics.lastValue}</th>
        </tr>
      </thead>
      <tbody ref={body}>
        {rows.map((row, index) => (
          <>
            {isNewGroup(rows, index) && (
              <tr key={`group ${row.name}`} class="topics-group">
                <td colSpan={6}>{group(row.name)}</td>
              </tr>
            )}
            <TopicRow
              key={row.name}
              context={context}
              row={row}
              nowMs={nowMs}
              isChosen={row.name === chosen}
              onChoose={onChoose}
            />
          </>
        ))}
      </tbody>
    </table>
  );
}

/** The namespace that a topic is in, empty for the root. */
function group(name: string): string {
  return name.slice(0, name.indexOf("/", 1) + 1);
}

function isNewGroup(rows: Row[], index: number): boolean {
  const own = group(rows[index]!.name);
  // A namespace with one topic needs no heading.
  const isAlone = index + 1 >= rows.length || group(rows[index + 1]!.name) !== own;
  return own !== "" && !isAlone && (index === 0 || group(rows[index - 1]!.name) !== own);
}

function TopicRow(props: {
  context: PanelContext;
  row: Row;
  /** The time of the last tick. It is a property because a row that reads signals is not drawn again by its parent. */
  nowMs: number;
  isChosen: boolean;
  onChoose: (topic: string) => void;
}) {
  const { name, typeName, isPublished } = props.row;
  const { robot } = props.context;
  const shownName = useMemo(() => breakable(name), [name]);
  const feed = robot.feed(name);
  const now = props.nowMs;
  const message = feed.lastMessage();
  let value = isPublished ? texts.topics.waiting : texts.topics.subscribedOnly;
  if (message instanceof Error) value = message.message;
  else if (message) value = brief(message, MAIN_FIELDS[typeName]);
  const isFresh = message !== undefined && !feed.isStale(now);
  return (
    <tr data-topic={name} aria-selected={props.isChosen} onClick={() => props.onChoose(name)}>
      <td>
        <button type="button" class="topics-name">
          {shownName}
        </button>
      </td>
      <td class="topics-type wide">{typeName}</td>
      <td class="number wide muted">
        {robot.publishers.value.get(name)?.length ?? 0} → {robot.subscribers.value.get(name)?.length ?? 0}
      </td>
      <td class="number">{formatRate(feed.rate.hertz(now))}</td>
      <td class="number wide">{formatBandwidth(feed.rate.bytesPerSecond(now))}</td>
      <td class={isFresh ? "topics-value" : "topics-value stale"}>{value}</td>
    </tr>
  );
}

export default preactPanel(TopicsPanel);

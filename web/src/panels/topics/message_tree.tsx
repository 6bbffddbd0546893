// Any message as a tree that can be opened; large arrays are shown in parts.
import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { formatNumber } from "../../shell/format.ts";
import { texts } from "../../texts.ts";
import type { Message, Value } from "../../wire/decode.ts";
import { brief, briefValue, isStamp } from "./brief.ts";

const PART = 50;
/** The limit of one string: drawing a megabyte several times a second would block the page. */
const MAX_TEXT = 5000;

interface TreeProps {
  value: Value;
  path: string;
  name: string;
  /** A link after a number, such as "Plot". */
  onPlot?: (path: string) => void;
}

export function MessageTree({ message, onPlot }: { message: Message; onPlot?: (path: string) => void }) {
  return (
    <div class="tree">
      {Object.entries(message).map(([name, value]) => (
        <Branch key={name} name={name} path={name} value={value} onPlot={onPlot} />
      ))}
    </div>
  );
}

function Branch({ name, path, value, onPlot }: TreeProps) {
  if (Array.isArray(value) || ArrayBuffer.isView(value)) {
    return <ArrayBranch name={name} path={path} value={value} onPlot={onPlot} />;
  }
  if (typeof value === "object" && !isStamp(value)) {
    return (
      <Folder name={name} note={brief(value as Message)} isOpen={path === name && name !== "header"}>
        {() =>
          Object.entries(value as Message).map(([key, each]) => (
            <Branch key={key} name={key} path={`${path}.${key}`} value={each} onPlot={onPlot} />
          ))
        }
      </Folder>
    );
  }
  const isNumber = typeof value === "number" || typeof value === "bigint" || typeof value === "boolean";
  return (
    <div>
      <span class="tree-key">{name}: </span>
      <span class={typeof value === "number" ? "tree-value number" : "tree-value"}>
        {typeof value === "string"
          ? shownText(value)
          : typeof value === "number"
            ? shown(value)
            : briefValue(value)}
      </span>
      {isNumber && onPlot && (
        <button type="button" class="topics-name plot-link" onClick={() => onPlot(path)}>
          {texts.topics.plot}
        </button>
      )}
    </div>
  );
}

function ArrayBranch({ name, path, value, onPlot }: TreeProps) {
  const count = useSignal(PART);
  const list = value as ArrayLike<Value>;
  return (
    <Folder
      name={name}
      note={texts.topics.elements(list.length)}
      isOpen={list.length > 0 && list.length <= 8}
    >
      {() => (
        <>
          {Array.from({ length: Math.min(count.value, list.length) }, (_, index) => (
            <Branch
              key={String(index)}
              name={`[${index}]`}
              path={`${path}[${index}]`}
              value={list[index]!}
              onPlot={onPlot}
            />
          ))}
          {list.length > count.value && (
            <button
              type="button"
              class="topics-name"
              onClick={() => {
                count.value += PART;
              }}
            >
              {texts.topics.showMore(Math.min(PART, list.length - count.value))}
            </button>
          )}
        </>
      )}
    </Folder>
  );
}

function Folder(props: { name: string; note: string; isOpen: boolean; children: () => ComponentChildren }) {
  const isOpen = useSignal(props.isOpen);
  return (
    <details
      open={isOpen.value}
      onToggle={(event) => {
        isOpen.value = event.currentTarget.open;
      }}
    >
      <summary>
        <span class="tree-key">{props.name}</span>{" "}
        {!isOpen.value && <span class="tree-note">{props.note}</span>}
      </summary>
      {isOpen.value && <div>{props.children()}</div>}
    </details>
  );
}

function shownText(value: string): string {
  const text = JSON.stringify(value.slice(0, MAX_TEXT));
  return value.length > MAX_TEXT ? `${text} … ${texts.topics.characters(value.length)}` : text;
}

function shown(value: number): string {
  return Number.isInteger(value) ? String(value) : formatNumber(value, 7);
}

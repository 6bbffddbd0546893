// Small parts that many panels use.
import { useSignal } from "@preact/signals";
import { type ComponentChildren, Fragment } from "preact";
import { texts } from "../texts.ts";
import { copyText } from "./copy_text.ts";
import { Icon, type IconName } from "./icons.tsx";

/** The content of an empty panel: the missing data, and the command that provides it. */
export function EmptyState(props: { icon: IconName; title: string; text?: string; command?: string }) {
  return (
    <div class="empty">
      <Icon name={props.icon} size={32} />
      <h2>{props.title}</h2>
      {props.text && <p>{props.text}</p>}
      {props.command && (
        <div class="command">
          <code>
            {props.command.split(" ").map((word) => (
              <span key={word}>{word} </span>
            ))}
          </code>
          <CopyButton text={props.command} />
        </div>
      )}
    </div>
  );
}

/** A name that breaks after its slashes and underscores first. */
export function breakable(name: string): ComponentChildren {
  const parts = name.split(/(?<=.[/_])/);
  if (parts.length === 1) return name;
  return parts.map((part, index) => (
    <Fragment key={index}>
      {part}
      <wbr />
    </Fragment>
  ));
}

export function IconButton(props: {
  icon: IconName;
  label: string;
  onClick: () => void;
  isPressed?: boolean;
  isDisabled?: boolean;
}) {
  return (
    <button
      type="button"
      class="icon-button"
      title={props.label}
      aria-label={props.label}
      aria-pressed={props.isPressed}
      disabled={props.isDisabled}
      onClick={props.onClick}
    >
      <Icon name={props.icon} />
    </button>
  );
}

const COPIED_MS = 1500;

export function CopyButton({ text, label }: { text: string; label?: string }) {
  const isCopied = useSignal(false);
  const copy = async () => {
    isCopied.value = await copyText(text);
    setTimeout(() => {
      isCopied.value = false;
    }, COPIED_MS);
  };
  const name = isCopied.value ? texts.shell.copied : (label ?? texts.topics.copyCommand);
  return <IconButton icon={isCopied.value ? "check" : "copy"} label={name} onClick={() => void copy()} />;
}

export function SearchField(props: { value: string; label: string; onInput: (text: string) => void }) {
  return (
    <label class="search">
      <Icon name="search" size={18} />
      <input
        type="search"
        value={props.value}
        placeholder={props.label}
        aria-label={props.label}
        autocomplete="off"
        spellcheck={false}
        onInput={(event) => props.onInput(event.currentTarget.value)}
      />
    </label>
  );
}

export type Level = "ok" | "warning" | "error" | "stale";

/** A colored dot with its meaning as text for screen readers. */
export function Badge({ level, children }: { level: Level; children: ComponentChildren }) {
  return <span class={`badge ${level}`}>{children}</span>;
}

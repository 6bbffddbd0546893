// The list of all numbers on the graph, to choose from.
import { useComputed, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { seriesOfTyped } from "../../plot/plot_names.ts";
import { compareNames } from "../../shell/format.ts";
import { Icon } from "../../shell/icons.tsx";
import { EmptyState, IconButton, SearchField } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { numericPaths } from "../../wire/path.ts";
import type { PanelContext } from "../panel.ts";

// Longer lists are not readable; the search finds the others.
const MAX_SHOWN = 300;

interface Props {
  context: PanelContext;
  chosen: readonly string[];
  onToggle: (id: string) => void;
  onClose: () => void;
}

export function PathPicker({ context, chosen, onToggle, onClose }: Props) {
  const search = useSignal("");
  const host = useRef<HTMLElement>(null);
  useEffect(() => {
    // On phones, the keyboard would cover the list.
    if (matchMedia("(pointer: fine)").matches) host.current?.querySelector("input")?.focus();
  }, []);
  const ids = useComputed(() => {
    const found: string[] = [];
    const topics = [...context.robot.topics.value.values()].filter((each) => each.isPublished);
    topics.sort((a, b) => compareNames(a.name, b.name));
    for (const topic of topics) {
      try {
        for (const path of numericPaths(topic.type())) found.push(`${topic.name}.${path}`);
      } catch {
        // The Topics panel shows why a topic cannot be read.
      }
    }
    return found;
  }).value;
  const words = withSlashes(search.value).split(/\s+/).filter(Boolean);
  const found = ids.filter((id) => words.every((word) => withSlashes(id).includes(word)));
  const typed = seriesOfTyped(search.value, context.robot.topics.value);
  const shown = [...new Set([...typed, ...found])];
  return (
    <aside
      class="plots-picker"
      ref={host}
      aria-label={texts.plots.add}
      onKeyDown={(event) => {
        if (event.key === "Escape") onClose();
        const next = shown.find((id) => !chosen.includes(id));
        if (event.key === "Enter" && event.target instanceof HTMLInputElement && words.length > 0 && next)
          onToggle(next);
      }}
    >
      <div class="plots-picker-head">
        <SearchField
          value={search.value}
          label={texts.plots.search}
          onInput={(text) => {
            search.value = text;
          }}
        />
        <IconButton icon="close" label={texts.topics.close} onClick={onClose} />
      </div>
      <div class="plots-picker-list">
        {shown.length === 0 && <EmptyState icon="plots" title={texts.plots.noNumbers} />}
        {shown.slice(0, MAX_SHOWN).map((id) => (
          <button
            key={id}
            type="button"
            class="plots-path"
            aria-pressed={chosen.includes(id)}
            onClick={() => onToggle(id)}
          >
            <span>
              <span class="muted">{id.slice(0, id.indexOf("."))}</span>
              {id.slice(id.indexOf("."))}
            </span>
            {chosen.includes(id) && <Icon name="check" size={18} />}
          </button>
        ))}
      </div>
    </aside>
  );
}

/** A name for comparison: rqt_plot has slashes where the list has dots. */
function withSlashes(name: string): string {
  return name.toLowerCase().replaceAll(".", "/");
}

// Images of all cameras, or of one.
import type { Signal } from "@preact/signals";
import { EmptyState } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import type { Turn } from "./image_view.ts";
import { Picture } from "./picture.tsx";
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
      {!context.isCard && (topics.length > 1 || chosen !== "") && (
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
          <Picture
            key={topic}
            context={context}
            topic={topic}
            turn={settings.value.turns?.[topic]}
            onTurn={(turn) => {
              settings.value = { ...settings.value, turns: { ...settings.value.turns, [topic]: turn } };
            }}
          />
        ))}
      </div>
    </div>
  );
}

export default preactPanel(ImagesPanel);

// Controls for all topics and services that accept input, made from their definitions.
import type { Signal } from "@preact/signals";
import { EmptyState } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { graphOf } from "../graph_of.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { Control } from "./control.tsx";
import { fitsCard } from "./control_kind.ts";
import { controllableTopics } from "./controllable.ts";
import { ServiceControl, tappableServices } from "./service_control.tsx";

interface ControlsSettings {
  /** A card shows one topic; the page scrolls to it. */
  topic?: string;
}

function showElement(element: Element | null): void {
  element?.scrollIntoView({ block: "nearest" });
}

function ControlsPanel({ context }: { context: PanelContext }) {
  const { topic } = (context.settings as Signal<ControlsSettings>).value;
  const { robot } = context;
  if (context.isCard) return <Control context={context} topicName={topic ?? ""} />;
  const graph = graphOf(robot);
  const topics = controllableTopics(graph);
  // Forms come after the small controls.
  const isForm = (name: string) => !fitsCard(graph.topics.get(name)!);
  const topicCard = (name: string) => (
    <section class="control-card" key={name} ref={name === topic ? showElement : undefined}>
      <Control context={context} topicName={name} />
    </section>
  );
  const services = tappableServices(robot.services.value.values());
  if (topics.length === 0 && services.length === 0)
    return <EmptyState icon="controls" title={texts.controls.none} text={texts.controls.noneText} />;
  return (
    <div class="controls-grid">
      {topics.filter((each) => !isForm(each)).map(topicCard)}
      {services.map((each) => (
        <section class="control-card" key={each.name}>
          <ServiceControl context={context} service={each} />
        </section>
      ))}
      {topics.filter(isForm).map(topicCard)}
    </div>
  );
}

export default preactPanel(ControlsPanel);

// The services of the robot: choose one, fill its request, read its response.
import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Service } from "../../connection/protocol.ts";
import { type Draft, MessageForm } from "../../forms/message_form.tsx";
import { EmptyState, SearchField } from "../../shell/parts.tsx";
import { texts } from "../../texts.ts";
import { decoder, type Message } from "../../wire/decode.ts";
import { parseDefinition } from "../../wire/definition.ts";
import { encoder } from "../../wire/encode.ts";
import type { StructNode } from "../../wire/schema.ts";
import type { PanelContext } from "../panel.ts";
import { preactPanel } from "../preact_panel.tsx";
import { MessageTree } from "../topics/message_tree.tsx";
import { isPlumbing } from "./plumbing.ts";

interface ServicesSettings {
  service?: string;
  search?: string;
  plumbing?: boolean;
}

function ServicesPanel({ context }: { context: PanelContext }) {
  const settings = context.settings as Signal<ServicesSettings>;
  const { robot } = context;
  const { service: chosen = "", search = "", plumbing = false } = settings.value;
  const all = [...robot.services.value.values()].sort((a, b) => (a.name < b.name ? -1 : 1));
  const shown = all.filter(
    (each) =>
      (plumbing || !isPlumbing(each)) &&
      `${each.name} ${each.type}`.toLowerCase().includes(search.toLowerCase()),
  );
  const service = robot.services.value.get(chosen);
  // The robot does not offer its services to such a page.
  const isViewOnly = robot.info.value?.metadata?.rights === "view";
  const change = (to: ServicesSettings) => {
    settings.value = { ...settings.value, ...to };
  };
  if (context.isCard) return service ? <CallForm context={context} service={service} /> : null;
  return (
    <div class="services">
      <div class="services-list">
        <SearchField
          value={search}
          label={texts.services.search}
          onInput={(text) => change({ search: text })}
        />
        <label class="check">
          <input
            type="checkbox"
            checked={plumbing}
            onChange={(event) => change({ plumbing: event.currentTarget.checked })}
          />
          {texts.services.plumbing}
        </label>
        {shown.length === 0 && (
          <EmptyState
            icon="services"
            title={isViewOnly ? texts.connect.viewOnly : texts.services.none}
            text={isViewOnly ? texts.services.viewOnlyText : texts.services.noneText}
          />
        )}
        <ul class="services-rows">
          {shown.map((each) => (
            <li key={each.name}>
              <button
                type="button"
                class="services-row"
                aria-current={each.name === chosen}
                onClick={() => change({ service: each.name })}
              >
                <span class="services-name">{each.name}</span>
                <span class="form-type">{each.type}</span>
              </button>
            </li>
          ))}
        </ul>
      </div>
      <div class="services-detail">
        {service ? (
          <CallForm key={service.name} context={context} service={service} />
        ) : (
          shown.length > 0 && <EmptyState icon="services" title={texts.services.choose} />
        )}
      </div>
    </div>
  );
}

type Answer = { message: Message; ms: number } | { error: string };

function CallForm({ context, service }: { context: PanelContext; service: Service }) {
  const draft = useSignal<Draft>({});
  const answer = useSignal<Answer | undefined>(undefined);
  const isCalling = useSignal(false);
  const result = useRef<HTMLDivElement>(null);
  // Below a long form, the answer is not on the screen.
  useEffect(() => {
    if (answer.value !== undefined) result.current?.scrollIntoView({ block: "nearest" });
  }, [answer.value]);
  const types = readTypes(service);
  if (typeof types === "string") return <p class="problem">{types}</p>;
  const call = async () => {
    isCalling.value = true;
    const startMs = performance.now();
    try {
      const response = await context.robot.gateway.call(service.name, encoder(types.request)(draft.value));
      const message = decoder(types.response)(response);
      answer.value = { message, ms: performance.now() - startMs };
    } catch (error) {
      answer.value = { error: (error as Error).message };
    } finally {
      isCalling.value = false;
    }
  };
  const current = answer.value;
  return (
    <form
      class="any-form"
      onSubmit={(event) => {
        event.preventDefault();
        void call();
      }}
    >
      <h2 class="services-title">
        {service.name} <span class="form-type">{service.type}</span>
      </h2>
      <MessageForm
        type={types.request}
        draft={draft.value}
        onChange={(next) => {
          draft.value = next;
        }}
      />
      <button type="submit" class="button primary" disabled={isCalling.value || !context.robot.mayAct.value}>
        {isCalling.value ? texts.services.calling : texts.services.call}
      </button>
      <div ref={result}>
        {current && "error" in current && <p class="problem">{current.error}</p>}
        {current && "message" in current && (
          <div class="answer">
            <p class="empty-line">{texts.services.answered(current.ms)}</p>
            <MessageTree message={current.message} />
          </div>
        )}
      </div>
    </form>
  );
}

function readTypes(service: Service): { request: StructNode; response: StructNode } | string {
  const { request, response } = service;
  try {
    return {
      request: parseDefinition(request.schemaName, request.schema),
      response: parseDefinition(response.schemaName, response.schema),
    };
  } catch (error) {
    return (error as Error).message;
  }
}

export default preactPanel(ServicesPanel);

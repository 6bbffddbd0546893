// The control of a service with a simple request: a button for an empty one, a switch for a single bool.
import { useSignal } from "@preact/signals";
import type { Service } from "../../connection/protocol.ts";
import { callService } from "../../store/call_service.ts";
import type { Message } from "../../wire/decode.ts";
import { parseDefinition } from "../../wire/definition.ts";
import type { PanelContext } from "../panel.ts";
import { isPlumbing } from "../services/plumbing.ts";
import { brief } from "../topics/brief.ts";
import { PushButton, Toggle } from "./control.tsx";

/** The services of the robot that need no form. */
export function tappableServices(services: Iterable<Service>): Service[] {
  return [...services]
    .filter((service) => !isPlumbing(service) && tapOf(service) !== undefined)
    .sort((a, b) => (a.name < b.name ? -1 : 1));
}

/** The bool field of the request, or "" when it has no field; undefined when it needs a form. */
function tapOf({ request }: Service): string | undefined {
  try {
    const [first, second] = parseDefinition(request.schemaName, request.schema).fields;
    if (first === undefined) return "";
    const isBool = first.node.kind === "primitive" && first.node.type === "bool";
    return isBool && second === undefined ? first.name : undefined;
  } catch {
    return undefined;
  }
}

export function ServiceControl({ context, service }: { context: PanelContext; service: Service }) {
  const answer = useSignal("");
  const isProblem = useSignal(false);
  // Nothing reports the state that the service begins with.
  const state = useSignal<boolean | undefined>(undefined);
  const field = tapOf(service);
  if (field === undefined) return null;
  const call = async (request: Message) => {
    try {
      const message = await callService(context.robot, service, request);
      isProblem.value = message.success === false;
      answer.value = typeof message.message === "string" ? message.message : brief(message);
      return !isProblem.value;
    } catch (error) {
      isProblem.value = true;
      answer.value = (error as Error).message;
      return false;
    }
  };
  return (
    <div class="control">
      <div class="control-head">
        <span class="control-topic">{service.name}</span>
        <span class="form-type">{service.type}</span>
      </div>
      <fieldset class="control-body" disabled={!context.robot.mayAct.value}>
        {field === "" ? (
          <PushButton send={() => void call({})} label={service.name.split("/").at(-1) ?? service.name} />
        ) : (
          <Toggle
            field={field}
            label={service.name}
            state={state}
            send={(request) => call(request as Message)}
          />
        )}
      </fieldset>
      {answer.value && <p class={isProblem.value ? "problem" : "empty-line"}>{answer.value}</p>}
    </div>
  );
}

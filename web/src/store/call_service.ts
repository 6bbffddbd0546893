// Calls a service with a message; the response is a message too.
import type { Service } from "../connection/protocol.ts";
import { decoder, type Message } from "../wire/decode.ts";
import { parseDefinition } from "../wire/definition.ts";
import { encoder } from "../wire/encode.ts";
import type { Robot } from "./robot.ts";

/** Rejects with the reason when the call fails. */
export async function callService(robot: Robot, service: Service, request: Message): Promise<Message> {
  const { request: asked, response: answered } = service;
  const payload = encoder(parseDefinition(asked.schemaName, asked.schema))(request);
  const response = await robot.gateway.call(service.name, payload);
  return decoder(parseDefinition(answered.schemaName, answered.schema))(response);
}

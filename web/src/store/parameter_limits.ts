// The descriptions of parameters by ROS 2 nodes: read-only, and the range of numbers. ROS 1 has none.
import type { Gateway } from "../connection/gateway.ts";
import type { Service } from "../connection/protocol.ts";
import { decoder, type Message } from "../wire/decode.ts";
import { parseDefinition } from "../wire/definition.ts";
import { encoder } from "../wire/encode.ts";

export interface ParameterLimits {
  readonly isReadOnly: boolean;
  readonly description: string;
  readonly min?: number;
  readonly max?: number;
  /** 0 for any step. */
  readonly step?: number;
}

const SERVICE = "/describe_parameters";
const TYPE = /^rcl_interfaces\/(srv\/)?DescribeParameters$/;

/** Groups full names by the node that can describe them; `name` is the name in ROS 2, with dots. */
export function byNode(
  names: Iterable<string>,
  services: ReadonlyMap<string, Pick<Service, "name" | "type">>,
): Map<string, { full: string; name: string }[]> {
  const nodes = [...services.values()]
    .filter(({ name, type }) => TYPE.test(type) && name.endsWith(SERVICE))
    .map(({ name }) => name.slice(0, -SERVICE.length))
    .sort((a, b) => b.length - a.length);
  const groups = new Map<string, { full: string; name: string }[]>();
  for (const full of names) {
    const node = nodes.find((each) => full.startsWith(`${each}/`));
    if (node === undefined) continue;
    const group = groups.get(node) ?? [];
    group.push({ full, name: full.slice(node.length + 1).replaceAll("/", ".") });
    groups.set(node, group);
  }
  return groups;
}

/** Asks each node for the limits of its parameters. A node that does not answer has none. */
export async function describeParameters(
  gateway: Gateway,
  services: ReadonlyMap<string, Service>,
  names: Iterable<string>,
): Promise<Map<string, ParameterLimits>> {
  const found = new Map<string, ParameterLimits>();
  const asking = [...byNode(names, services)].map(async ([node, wanted]) => {
    const service = services.get(node + SERVICE)!;
    const { request, response } = service;
    const payload = encoder(parseDefinition(request.schemaName, request.schema))({
      names: wanted.map(({ name }) => name),
    });
    const answer = await gateway.call(service.name, payload);
    const { descriptors } = decoder(parseDefinition(response.schemaName, response.schema))(answer);
    const byName = new Map((descriptors as Message[]).map((each) => [String(each.name), each]));
    for (const { full, name } of wanted) {
      const descriptor = byName.get(name);
      if (descriptor) found.set(full, limitsOf(descriptor));
    }
  });
  await Promise.allSettled(asking);
  return found;
}

/** Reads an rcl_interfaces/ParameterDescriptor. */
export function limitsOf(descriptor: Message): ParameterLimits {
  const ranges = [...list(descriptor.floating_point_range), ...list(descriptor.integer_range)];
  const range = ranges[0];
  const limits = {
    isReadOnly: descriptor.read_only === true,
    description: String(descriptor.description ?? ""),
  };
  if (range === undefined) return limits;
  return { ...limits, min: Number(range.from_value), max: Number(range.to_value), step: Number(range.step) };
}

function list(value: unknown): Message[] {
  return Array.isArray(value) ? value : [];
}

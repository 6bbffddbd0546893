// The messages of the Foxglove WebSocket protocol that the page uses. Binary ones are little endian.
// Source: https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md

export const SUBPROTOCOL = "foxglove.sdk.v1";

export interface Channel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
  schema: string;
}
export interface MessageSchema {
  encoding: string;
  schemaName: string;
  schema: string;
}
export interface Service {
  id: number;
  name: string;
  type: string;
  request: MessageSchema;
  response: MessageSchema;
}
export interface Parameter {
  name: string;
  value?: unknown;
  type?: string;
}
export interface Status {
  level: 0 | 1 | 2;
  message: string;
  id?: string;
}
export interface GraphUpdate {
  publishedTopics: { name: string; publisherIds: string[] }[];
  /** rostether's gateway adds the type of a topic that no node publishes, so that the page can publish it. */
  subscribedTopics: { name: string; subscriberIds: string[]; schemaName?: string; schema?: string }[];
  removedTopics: string[];
}
export interface ServerInfo {
  name: string;
  capabilities: string[];
  sessionId: string;
  metadata?: Record<string, string>;
}
/** The driver of a command topic: none, this page, or another client (an extension of rostether's gateway). */
export interface Lease {
  state: "free" | "driving" | "taken";
  /** The driver's name; empty without a driver. */
  driver: string;
}
/** A topic that the page publishes. */
export interface ClientChannel {
  topic: string;
  schemaName: string;
  schema: string;
  driver?: string;
}
export interface Playing {
  name: string;
  seconds: number;
  length: number;
  rate: number;
  paused: boolean;
  prefix: string;
}
/** The current and the finished recordings of the gateway (an extension of rostether's gateway). */
export interface Recordings {
  folder: string;
  active: { name: string; seconds: number; messages: number; topics: number; bytes: number } | null;
  files: { name: string; bytes: number; time: number }[];
  /** The current playback: its position and length in seconds, and the prefix of its topics. */
  playing?: Playing | null;
  /** The error of the last recording. */
  error?: string;
}
export type ServerText =
  | ({ op: "serverInfo" } & ServerInfo)
  | ({ op: "status" } & Status)
  | { op: "removeStatus"; statusIds: string[] }
  | { op: "advertise"; channels: Channel[] }
  | { op: "unadvertise"; channelIds: number[] }
  | { op: "advertiseServices"; services: Service[] }
  | { op: "unadvertiseServices"; serviceIds: number[] }
  | { op: "parameterValues"; parameters: Parameter[]; id?: string }
  | ({ op: "connectionGraphUpdate" } & GraphUpdate)
  | ({ op: "recordings" } & Recordings)
  | ({ op: "drive"; channelId: number } & Lease)
  | { op: "timeAnswer"; id: number; sec: number; nsec: number }
  | { op: "serviceCallFailure"; serviceId: number; callId: number; message: string };

export type ServerBinary =
  | { op: "message"; subscriptionId: number; timeNs: bigint; payload: Uint8Array }
  | { op: "time"; timeNs: bigint }
  | { op: "serviceResponse"; serviceId: number; callId: number; payload: Uint8Array }
  | { op: "asset"; requestId: number; data: Uint8Array | undefined; error: string };

const text = new TextDecoder();

/** Parses a binary message; undefined for unknown kinds. */
export function parseBinary(data: ArrayBuffer): ServerBinary | undefined {
  const view = new DataView(data);
  const opcode = data.byteLength > 0 ? view.getUint8(0) : 0;
  if (opcode === 1 && data.byteLength >= 13) {
    const payload = new Uint8Array(data, 13);
    return {
      op: "message",
      subscriptionId: view.getUint32(1, true),
      timeNs: view.getBigUint64(5, true),
      payload,
    };
  }
  if (opcode === 2 && data.byteLength >= 9) return { op: "time", timeNs: view.getBigUint64(1, true) };
  if (opcode === 3 && data.byteLength >= 13) {
    const start = 13 + view.getUint32(9, true);
    if (start > data.byteLength) return undefined;
    const payload = new Uint8Array(data, start);
    return {
      op: "serviceResponse",
      serviceId: view.getUint32(1, true),
      callId: view.getUint32(5, true),
      payload,
    };
  }
  if (opcode === 4 && data.byteLength >= 10) {
    const length = view.getUint32(6, true);
    if (10 + length > data.byteLength) return undefined;
    const error = text.decode(new Uint8Array(data, 10, length));
    const found = view.getUint8(5) === 0;
    const file = found ? new Uint8Array(data, 10 + length) : undefined;
    return { op: "asset", requestId: view.getUint32(1, true), data: file, error };
  }
  return undefined;
}

/** A message on a channel that the page advertised. */
export function messageData(channelId: number, payload: Uint8Array): Uint8Array<ArrayBuffer> {
  const frame = new Uint8Array(5 + payload.length);
  const view = new DataView(frame.buffer);
  view.setUint8(0, 1);
  view.setUint32(1, channelId, true);
  frame.set(payload, 5);
  return frame;
}

/** A service call with a request in encoding `ros1`. */
export function serviceRequest(
  serviceId: number,
  callId: number,
  payload: Uint8Array,
): Uint8Array<ArrayBuffer> {
  const encoding = new TextEncoder().encode("ros1");
  const frame = new Uint8Array(13 + encoding.length + payload.length);
  const view = new DataView(frame.buffer);
  view.setUint8(0, 2);
  view.setUint32(1, serviceId, true);
  view.setUint32(5, callId, true);
  view.setUint32(9, encoding.length, true);
  frame.set(encoding, 13);
  frame.set(payload, 13 + encoding.length);
  return frame;
}

// A viewer on Foxglove's own client library: node foxglove_client.mjs URL PROTOCOL
// It runs its checks one after another and prints, for each, {"check": name, "found": value} or "error".
import { createRequire } from "node:module";
import WebSocket from "ws";

const { FoxgloveClient } = createRequire(import.meta.url)("@foxglove/ws-protocol");
const [url, protocol] = process.argv.slice(2);
const LIMIT_MS = 30000;
const OPERATIONS = ["serverInfo", "status", "advertise", "unadvertise", "advertiseServices", "parameterValues"];
const ANSWERS = ["message", "serviceCallResponse", "serviceCallFailure", "fetchAssetResponse"];

const client = new FoxgloveClient({ ws: new WebSocket(url, [protocol]) });
const heard = [];
const waiting = new Set();
client.on("error", (error) => hear({ op: "error", text: String(error) }));
for (const op of [...OPERATIONS, ...ANSWERS, "connectionGraphUpdate"]) {
  client.on(op, (value) => hear({ op, value }));
}

function hear(event) {
  heard.push(event);
  for (const look of waiting) look();
}

function told() {
  const texts = heard.filter((each) => each.op !== "message").map((each) => JSON.stringify(each.value ?? each.text));
  return texts.join(" ").slice(-1000);
}

function wait(op, suits = () => true) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`no ${op} came; ${told()}`)), LIMIT_MS);
    const look = () => {
      const found = heard.find((event) => event.op === op && suits(event.value));
      if (!found) return;
      clearTimeout(timer);
      waiting.delete(look);
      resolve(found.value);
    };
    waiting.add(look);
    look();
  });
}

async function offered(op, key, name) {
  const all = await wait(op, (list) => list.some((each) => each[key] === name));
  return all.find((each) => each[key] === name);
}

const bytes = (view) => Buffer.from(view.buffer, view.byteOffset, view.byteLength);
const view = (buffer) => new DataView(buffer.buffer, buffer.byteOffset, buffer.byteLength);

function text(value) {
  const data = Buffer.from(value);
  const length = Buffer.alloc(4);
  length.writeUInt32LE(data.length);
  return Buffer.concat([length, data]);
}

async function call(request, encoding = "ros1") {
  const service = await offered("advertiseServices", "name", "/enable");
  const callId = ++call.count;
  client.sendServiceCallRequest({ serviceId: service.id, callId, encoding, data: view(request) });
  const failure = wait("serviceCallFailure", (each) => each.callId === callId).then((each) => ({ failure: each.message }));
  const response = wait("serviceCallResponse", (each) => each.callId === callId).then((each) => ({
    encoding: each.encoding,
    response: bytes(each.data).toString(encoding === "json" ? "utf8" : "hex"),
  }));
  return Promise.race([failure.catch(() => new Promise(() => {})), response.catch(() => new Promise(() => {}))]);
}
call.count = 0;

const checks = {
  async greeting() {
    const { name, capabilities, supportedEncodings } = await wait("serverInfo");
    return { name, capabilities, supportedEncodings };
  },
  async channel() {
    const { id, ...channel } = await offered("advertise", "topic", "/latched");
    return channel;
  },
  async nestedSchema() {
    return (await offered("advertise", "topic", "/pose")).schema;
  },
  async latched() {
    const channel = await offered("advertise", "topic", "/latched");
    const id = client.subscribe(channel.id);
    const message = await wait("message", (each) => each.subscriptionId === id);
    return {
      isNow: Math.abs(Number(message.timestamp / 1000000000n) - Date.now() / 1000) < 100,
      payload: bytes(message.data).toString("hex"),
    };
  },
  async manyInOrder() {
    const channel = await offered("advertise", "topic", "/count");
    const id = client.subscribe(channel.id);
    await wait("message", () => heard.filter((each) => each.value?.subscriptionId === id).length >= 50);
    client.unsubscribe(id);
    const numbers = heard
      .filter((each) => each.op === "message" && each.value.subscriptionId === id)
      .map((each) => each.value.data.getUint32(0, true));
    return numbers.every((each, index) => each === numbers[0] + index);
  },
  publish() {
    const raw = client.advertise({ topic: "/said", encoding: "ros1", schemaName: "std_msgs/String" });
    client.sendMessage(raw, text("raw"));
    const json = client.advertise({ topic: "/said", encoding: "json", schemaName: "std_msgs/String" });
    client.sendMessage(json, Buffer.from('{"data": "json"}'));
    return "sent";
  },
  async service() {
    const { id, ...service } = await offered("advertiseServices", "name", "/enable");
    return service;
  },
  call: () => call(Buffer.from([1])),
  callJson: () => call(Buffer.from('{"data": true}'), "json"),
  callBroken: () => call(Buffer.from([1, 2, 3])),
  async parameters() {
    client.getParameters([], "all");
    const { parameters } = await wait("parameterValues", (each) => each.id === "all");
    return parameters.filter((each) => each.name.startsWith("/robot/"));
  },
  async setParameter() {
    client.subscribeParameterUpdates(["/robot/speed"]);
    client.setParameters([{ name: "/robot/speed", value: 2.5, type: "float64" }], "set");
    await wait("parameterValues", (each) => each.id === "set");
    const told = await wait("parameterValues", (each) => each.id == undefined && each.parameters[0].value === 2.5);
    return told.parameters;
  },
  async asset() {
    client.fetchAsset("package://robot_model/meshes/arm.stl", 5);
    const answer = await wait("fetchAssetResponse", (each) => each.requestId === 5);
    return { status: answer.status, data: bytes(answer.data).toString() };
  },
  async assetOutside() {
    client.fetchAsset("package://robot_model/../../../../../../../etc/hostname", 6);
    const answer = await wait("fetchAssetResponse", (each) => each.requestId === 6);
    return answer.status;
  },
  async connectionGraph() {
    client.subscribeConnectionGraph();
    const graph = await wait("connectionGraphUpdate");
    return {
      latched: graph.publishedTopics.find((each) => each.name === "/latched")?.publisherIds,
      said: graph.subscribedTopics.find((each) => each.name === "/said")?.subscriberIds,
      enable: graph.advertisedServices.find((each) => each.name === "/enable")?.providerIds,
    };
  },
  mistakes: () => heard.filter((each) => each.op === "error" || (each.op === "status" && each.value.level === 2)),
};

for (const [check, run] of Object.entries(checks)) {
  try {
    console.log(JSON.stringify({ check, found: (await run()) ?? null }));
  } catch (error) {
    console.log(JSON.stringify({ check, error: String(error?.message ?? error) }));
  }
}
client.close();
process.stdout.write("", () => process.exit(0));

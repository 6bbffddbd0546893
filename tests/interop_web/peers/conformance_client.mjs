// The conformance program in JavaScript, written from docs/reference/wire-protocol.md alone.
// Usage: node conformance_client.mjs PORT

import net from "node:net";

const BUFFER_BYTES = 512;
const TIME_PERIOD_MS = 2500;
const HOST_LOST_MS = 11_000;
const TORN_MS = 200;
const PARAMETER_MS = 1000;
const CALL_MS = 3000;
const RECONNECT_MS = 300;

const TEXT_MD5 = "992ce8a1687cec8c8bd883ec73ca41d1";
const REAL_MD5 = "fdb28210bfa9d7c91146260178d9a584";
const EMPTY_MD5 = "d41d8cd98f00b204e9800998ecf8427e";
const SWITCH = ["conformance/switch", "std_srvs/SetBool"];
const TRIGGER = ["conformance/trigger", "std_srvs/Trigger"];
const RESPONSE_MD5 = "937c9679a518e3a18d831e57125ea522";

// The id of the announcement, the topic id, name, type, md5sum.
const ENDPOINTS = [
  [1, 100, "conformance/text_in", "std_msgs/String", TEXT_MD5],
  [1, 101, "conformance/real_in", "std_msgs/Float64", REAL_MD5],
  [1, 102, "conformance/ping", "std_msgs/Empty", EMPTY_MD5],
  [1, 103, "conformance/command", "std_msgs/UInt8", "7c8164229e7d2c17eb95e9231617fdee"],
  [3, 104, ...SWITCH, "8b94c1b53db61fb6aed406028ad6332a"],
  [5, 105, ...TRIGGER, RESPONSE_MD5],
  [0, 110, "conformance/text_out", "std_msgs/String", TEXT_MD5],
  [0, 111, "conformance/real_out", "std_msgs/Float64", REAL_MD5],
  [0, 112, "conformance/pong", "std_msgs/Time", "cd7166c74c552c311fbcc2fe5a7bc289"],
  [2, 113, ...SWITCH, RESPONSE_MD5],
  [4, 114, ...TRIGGER, EMPTY_MD5],
];

const sum = (bytes) => bytes.reduce((total, byte) => total + byte, 0) % 256;

function uint32(value) {
  const bytes = Buffer.alloc(4);
  bytes.writeUInt32LE(value);
  return bytes;
}

function text(value) {
  const bytes = Buffer.from(value);
  return Buffer.concat([uint32(bytes.length), bytes]);
}

function real(value) {
  const bytes = Buffer.alloc(8);
  bytes.writeDoubleLE(value);
  return bytes;
}

function frame(id, payload) {
  const head = Buffer.from([0xff, 0xfe, 0, 0, 0, 0, 0]);
  head.writeUInt16LE(payload.length, 2);
  head[4] = 255 - sum(head.subarray(2, 4));
  head.writeUInt16LE(id, 5);
  return Buffer.concat([head, payload, Buffer.from([255 - ((sum(head.subarray(5)) + sum(payload)) % 256)])]);
}

// Returns the text of a payload that is one string, or null.
function readText(payload) {
  const fits = payload.length >= 4 && payload.length === 4 + payload.readUInt32LE(0);
  return fits ? payload.subarray(4) : null;
}

// Returns the three lists of a parameter's answer, or null.
function readLists(payload) {
  let at = 0;
  const next = (size) => {
    if (at + size > payload.length) throw new RangeError("the answer is too short");
    at += size;
    return payload.subarray(at - size, at);
  };
  const list = (read) => {
    const values = [];
    for (let left = next(4).readUInt32LE(); left > 0; left--) values.push(read());
    return values;
  };
  try {
    const ints = list(() => next(4).readInt32LE());
    const floats = list(() => next(4).readFloatLE());
    const strings = list(() => next(next(4).readUInt32LE()));
    return at === payload.length ? { ints, floats, strings } : null;
  } catch (error) {
    if (error instanceof RangeError) return null;
    throw error;
  }
}

class Client {
  #socket;
  #bytes = Buffer.alloc(0);
  #isConfigured = false;
  #answered = 0;
  #clock = { hostNs: 0n, atNs: 0n };
  #waiting = new Map();
  #commands = Promise.resolve();

  constructor(socket) {
    this.#socket = socket;
    let torn;
    socket.on("data", (data) => {
      clearTimeout(torn);
      this.#bytes = Buffer.concat([this.#bytes, data]);
      this.#findFrames();
      torn = setTimeout(() => this.#dropTorn(), TORN_MS);
    });
    const ticking = setInterval(() => this.#tick(), TIME_PERIOD_MS);
    socket.on("close", () => {
      clearInterval(ticking);
      clearTimeout(torn);
    });
  }

  #send(id, payload) {
    if (id < 100 || this.#isConfigured) this.#socket.write(frame(id, payload));
  }

  #tick() {
    if (Date.now() - this.#answered > HOST_LOST_MS) this.#isConfigured = false;
    if (this.#isConfigured) this.#send(10, Buffer.alloc(8));
  }

  #dropTorn() {
    while (this.#bytes.length > 0) {
      this.#bytes = this.#bytes.subarray(1);
      this.#findFrames();
    }
  }

  #findFrames() {
    for (;;) {
      const start = this.#bytes.indexOf(0xff);
      const bytes = (this.#bytes = start < 0 ? Buffer.alloc(0) : this.#bytes.subarray(start));
      if (bytes.length < 2) return;
      if (bytes[1] !== 0xfe) {
        if (bytes[1] === 0x00 && !this.#isConfigured) this.#send(10, Buffer.alloc(8));
        this.#bytes = bytes.subarray(1);
        continue;
      }
      if (bytes.length < 5) return;
      const size = bytes.readUInt16LE(2);
      const isHeader = sum(bytes.subarray(2, 5)) === 255 && size <= BUFFER_BYTES;
      if (isHeader && bytes.length < 8 + size) return;
      if (isHeader && sum(bytes.subarray(5, 8 + size)) === 255) {
        this.#bytes = bytes.subarray(8 + size);
        this.#handle(bytes.readUInt16LE(5), bytes.subarray(7, 7 + size));
      } else {
        this.#bytes = bytes.subarray(1);
      }
    }
  }

  #handle(id, payload) {
    const size = payload.length;
    if (id === 0 && size === 0) this.#announce();
    else if (id === 6) this.#answer("parameter", readLists(payload));
    else if (id === 10 && size === 8) this.#setClock(payload.readUInt32LE(0), payload.readUInt32LE(4));
    else if (id === 11 && size === 0) this.#isConfigured = false;
    else if (id === 100 && readText(payload) !== null) this.#send(110, payload);
    else if (id === 101 && size === 8) this.#send(111, payload);
    else if (id === 102 && size === 0) this.#send(112, this.#now());
    else if (id === 103 && size === 1) {
      const command = payload[0];
      this.#commands = this.#commands.then(() => this.#obey(command));
    } else if (id === 104 && size === 1) {
      this.#send(113, Buffer.concat([payload, text(payload[0] ? "on" : "off")]));
    } else if (id === 105 && size >= 5) this.#answer("call", readText(payload.subarray(1)));
  }

  #announce() {
    this.#isConfigured = true;
    this.#answered = Date.now();
    this.#send(10, Buffer.alloc(8));
    for (const [announcement, id, ...texts] of ENDPOINTS) {
      const topicId = uint32(id).subarray(0, 2);
      this.#send(announcement, Buffer.concat([topicId, ...texts.map(text), uint32(BUFFER_BYTES)]));
    }
  }

  #setClock(seconds, nanoseconds) {
    this.#answered = Date.now();
    this.#clock = { hostNs: BigInt(seconds) * 1_000_000_000n + BigInt(nanoseconds), atNs: process.hrtime.bigint() };
  }

  #now() {
    const ns = this.#clock.hostNs + process.hrtime.bigint() - this.#clock.atNs;
    return Buffer.concat([uint32(Number(ns / 1_000_000_000n)), uint32(Number(ns % 1_000_000_000n))]);
  }

  // Sends a request; returns its answer, or null after the time limit.
  #ask(kind, id, payload, limitMs) {
    return new Promise((resolve) => {
      this.#waiting.set(kind, resolve);
      this.#send(id, payload);
      setTimeout(() => resolve(null), limitMs);
    }).finally(() => this.#waiting.delete(kind));
  }

  #answer(kind, value) {
    if (value !== null) this.#waiting.get(kind)?.(value);
  }

  #parameter(name) {
    return this.#ask("parameter", 6, text(`conformance/${name}`), PARAMETER_MS);
  }

  async #obey(command) {
    if (command === 1) {
      for (const [level, name] of ["debug", "info", "warn", "error", "fatal"].entries()) {
        this.#send(7, Buffer.concat([Buffer.from([level]), text(name)]));
      }
    } else if (command === 2) {
      const message = await this.#ask("call", 114, Buffer.alloc(0), CALL_MS);
      if (message !== null) this.#send(110, text(message));
    } else if (command === 3) {
      for (const each of (await this.#parameter("ints"))?.ints ?? []) this.#send(111, real(each));
    } else if (command === 4) {
      for (const each of (await this.#parameter("float"))?.floats ?? []) this.#send(111, real(each));
    } else if (command === 5) {
      const lists = await this.#parameter("text");
      if (lists !== null) this.#send(110, text(lists.strings[0] ?? "none"));
    }
  }
}

function connect(port) {
  const socket = net.connect({ port, host: "127.0.0.1", noDelay: true });
  socket.on("connect", () => new Client(socket));
  socket.on("error", () => {});
  socket.on("close", () => setTimeout(connect, RECONNECT_MS, port));
}

connect(Number(process.argv[2]));

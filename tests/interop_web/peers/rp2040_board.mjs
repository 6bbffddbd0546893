// Runs a program for an RP2040 with rp2040js, its UART0 on a TCP connection: rp2040_board.mjs IMAGE HOST PORT
import { readFileSync } from "node:fs";
import { connect } from "node:net";

import { Simulator } from "rp2040js";

const [image, host, port] = process.argv.slice(2);
const FLASH = 0x10000000;
// An emulated cycle: at this speed the board's clock keeps up with the real one.
const CYCLE_NS = 1e9 / 12e6;
const SLICE_CYCLES = 12000;

const { rp2040, clock } = new Simulator();
rp2040.flash.set(readFileSync(image));
const { core } = rp2040;
core.VTOR = FLASH;
core.SP = rp2040.readUint32(FLASH);
core.PC = rp2040.readUint32(FLASH + 4) & ~1;

const [uart] = rp2040.uart;
const received = [];
const line = connect(Number(port), host);
line.on("data", (bytes) => received.push(...bytes));
line.on("close", () => process.exit());

let sent = [];
uart.onByte = (byte) => sent.push(byte);

const began = performance.now();
let ranMs = 0;
function run() {
  for (let cycles = 0; cycles < SLICE_CYCLES; ) {
    if (received.length && !uart.rxFIFO.full) uart.feedByte(received.shift());
    const took = core.executeInstruction();
    clock.tick(took * CYCLE_NS);
    cycles += took;
  }
  if (sent.length) line.write(Buffer.from(sent));
  sent = [];
  ranMs += (SLICE_CYCLES * CYCLE_NS) / 1e6;
  setTimeout(run, Math.max(0, began + ranMs - performance.now()));
}
line.on("connect", run);

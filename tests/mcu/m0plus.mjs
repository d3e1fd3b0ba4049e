// Runs a program in the RAM of an emulated RP2040, a Cortex-M0+: `node m0plus.mjs PROGRAM.bin`.
// Serves the semihosting calls of port_arm.cpp and prints nothing else.
import { readFileSync } from 'node:fs';

import { RP2040 } from '../board/rp2040js.mjs';

const RAM = 0x20000000;
const MOST_INSTRUCTIONS = 400e6;

const chip = new RP2040();
chip.logger = { info() {}, debug() {}, warn() {}, error: console.error };
chip.sram.set(readFileSync(process.argv[2]), 0);
chip.core.VTOR = RAM;
chip.core.reset();

let over = false;
let executed = 0;
chip.onBreak = () => {
  const [operation, argument] = chip.core.registers;
  if (operation === 0x04) {
    let end = argument - RAM;
    while (chip.sram[end] !== 0) ++end;
    process.stdout.write(Buffer.from(chip.sram.subarray(argument - RAM, end)));
  } else if (operation === 0x30) {
    new DataView(chip.sram.buffer, chip.sram.byteOffset).setUint32(argument - RAM, executed, true);
  } else {
    over = true;
  }
};
for (; !over && executed < MOST_INSTRUCTIONS; ++executed) {
  const cycles = chip.core.executeInstruction();
  if ((executed & 63) === 0) chip.clock.tick(64 * cycles);
}
process.exit(over ? 0 : 1);

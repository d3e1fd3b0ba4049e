// A USB host and a test bench round the emulated chip, told what to do by lines of JSON on standard
// input, one answer a line: {"do": "...", ...} -> {"ok": ...} or {"error": "..."}. While a command runs,
// a coupled world is asked by lines {"world": ...}.
import { readFileSync, readSync, writeSync } from 'node:fs';
import { createInterface } from 'node:readline';

import { Chip, PowerCut } from './chip.mjs';

const FRAME_NS = 1e6;
const RETRY_NS = 20e3; // a host repeats a token that was not acknowledged
const STATUS_GAP_NS = 60e3;
const hex = (text) => Uint8Array.from(Buffer.from(text, 'hex'));
const text = (bytes) => Buffer.from(bytes).toString('hex');

let chip = null;

/** One line of a file, as soon as it is there. */
function readLine(file) {
  const bytes = Buffer.alloc(65536);
  let size = 0;
  do {
    size += readSync(file, bytes, size, bytes.length - size);
  } while (bytes[size - 1] !== 0x0a);
  return bytes.toString('ascii', 0, size);
}

/** Repeats a token until it is answered. */
function transact(endpoint, data, withinNs) {
  const end = chip.ns + withinNs;
  for (;;) {
    const answer = chip.token(endpoint, data);
    if (answer !== 'nak' || chip.ns >= end) return answer;
    chip.runUntil(chip.ns + RETRY_NS);
  }
}

/** A control transfer: {stall}, {timeout} or {data}. */
function control({ setup, data = '', partial = false }) {
  const request = hex(setup);
  const length = request[6] | (request[7] << 8);
  const isIn = (request[0] & 0x80) !== 0;
  const within = 50 * FRAME_NS;
  chip.setup(request);
  chip.runUntil(chip.ns + RETRY_NS);
  const result = [];
  const fail = (answer) => {
    chip.runUntil(chip.ns + STATUS_GAP_NS);
    return answer === 'stall' ? { stall: true } : { timeout: true };
  };
  if (isIn) {
    while (result.length < length) {
      const answer = transact(0, null, within);
      if (typeof answer === 'string') return fail(answer);
      result.push(...answer);
      if (answer.length < 64) break;
    }
    const status = transact(0, new Uint8Array(0), within);
    if (status !== true) return fail(status);
  } else {
    const bytes = hex(data);
    for (let at = 0; at < bytes.length; at += 64) {
      const answer = transact(0, bytes.subarray(at, at + 64), within);
      if (answer !== true) return fail(answer);
    }
    const status = transact(0, null, within);
    if (typeof status === 'string') return fail(status);
    if (status.length !== 0) return { error: 'data in a status stage' };
  }
  chip.runUntil(chip.ns + STATUS_GAP_NS);
  return { data: text(result) };
}

const commands = {
  boot({ rom, image, serial }) {
    const flash = new Uint8Array(2 * 1024 * 1024).fill(0xff);
    for (const [address, page] of Object.entries(image)) flash.set(hex(page), Number(address));
    chip = new Chip({ rom: new Uint8Array(readFileSync(rom)), flash, serial: hex(serial) });
    return true;
  },
  /** This chip does not tell a supply that was too low from one that was switched on. */
  power_cycle() {
    chip.powerUp();
    return true;
  },
  /** As the boot ROM does once a file was copied. */
  start_copied() {
    chip.startCopied();
    return true;
  },
  run({ ns }) {
    chip.runUntil(chip.ns + ns);
    return chip.ns;
  },
  wait_attached({ within_ns }) {
    return chip.runUntil(chip.ns + within_ns, () => chip.attached);
  },
  bus_reset() {
    chip.busReset();
    chip.runUntil(chip.ns + 10 * FRAME_NS);
    return true;
  },
  suspend() {
    chip.suspend();
    return true;
  },
  resume() {
    chip.resume();
    return true;
  },
  control,
  out({ endpoint, data, within_ns }) {
    const answer = transact(endpoint, hex(data), within_ns);
    return answer === true ? 'ack' : answer;
  },
  in({ endpoint, within_ns }) {
    const answer = transact(endpoint, null, within_ns);
    return typeof answer === 'string' ? answer : { data: text(answer) };
  },
  pin({ pin, high }) {
    chip.setPin(pin, high);
    return true;
  },
  high_share({ pins }) {
    return pins.map((pin) => chip.highShare(pin));
  },
  /** Turns the encoder by so many edges, A leading B for positive ones; with step 2 both at once. */
  turn({ edges, period_ns, pin_a = 2, step = 1 }) {
    for (let n = 0; n < Math.abs(edges); ++n) {
      chip.turn(step * Math.sign(edges), pin_a);
      chip.runUntil(chip.ns + period_ns);
    }
    return true;
  },
  /** A world answers on the file that was named at the start what standard output asks of it. */
  couple() {
    chip.couple((motor, brake, enabled) => {
      writeSync(1, `${JSON.stringify({ world: [motor, brake, enabled] })}\n`);
      return JSON.parse(readLine(Number(process.argv[2])));
    });
    return true;
  },
  /** From now on `watchdog_least_left_ns` is of what is to come. */
  watch_feeding() {
    chip.leastLeft = null;
    return true;
  },
  /** They count anyway: from now on the maximum is of later ticks. */
  count_instructions() {
    chip.tickInstructions = 0;
    return true;
  },
  cut_wires({ pins }) {
    for (const pin of pins) chip.setPin(pin, true);
    chip.cut = new Set(pins);
    return true;
  },
  encoder_counter() {
    chip.catchUp();
    return chip.mcu.pio[0].machines[0].y >>> 0;
  },
  pin_functions({ pins }) {
    return pins.map((pin) => chip.mcu.gpio[pin].functionSelect);
  },
  /** Changes the motor, the sensor's zero, or what the sensor says whatever flows. */
  motor({ zero = 2048, sensor_amperes: sensed = null, ...changes }) {
    Object.assign(chip.motor, changes);
    chip.zero = zero;
    chip.sensorAmperes = sensed;
    return true;
  },
  amperes() {
    return chip.amperes;
  },
  cut_flash({ after_bytes }) {
    chip.cutAfterBytes = after_bytes;
    return true;
  },
  erase_time({ ns }) {
    chip.eraseNs = ns;
    return true;
  },
  spoil_flash({ byte }) {
    chip.spoiltByte = byte;
    return true;
  },
  write_flash({ address, data }) {
    chip.flash.set(hex(data), address);
    return true;
  },
  flash({ address, size }) {
    return text(chip.flash.subarray(address, address + size));
  },
  memory({ address, size }) {
    return text(chip.mcu.sram.subarray(address - 0x20000000, address - 0x20000000 + size));
  },
  poke({ address, word }) {
    chip.mcu.sramView.setUint32(address - 0x20000000, word, true);
    return true;
  },
  trace({ places }) {
    chip.places = new Map(places.map(({ at, ...place }) => [at, place]));
    return true;
  },
  passed() {
    return chip.passed.splice(0);
  },
  status() {
    return {
      ns: chip.ns,
      watchdog_resets: chip.watchdogResets,
      watchdog_least_left_ns: chip.leastLeft,
      bootloader: chip.bootloader,
      tick_ns: chip.tickNs,
      interrupt_ns: chip.interruptNs,
      tick_instructions: chip.tickInstructions,
      pwm_starts: chip.pwmStarts,
      lost: chip.lost,
      address: chip.mcu.usbCtrl.addrEndp & 0x7f,
      stack: chip.mcu.core.SP,
      pc: chip.mcu.core.PC,
    };
  },
  hang(how) {
    chip.hang(how);
    return true;
  },
  stop_ticks() {
    chip.stopTicks();
    return true;
  },
  hard_fault() {
    chip.hardFault();
    return true;
  },
};

for await (const line of createInterface({ input: process.stdin })) {
  const { do: name, ...details } = JSON.parse(line);
  let answer;
  try {
    answer = { ok: commands[name](details) };
  } catch (error) {
    if (!(error instanceof PowerCut)) {
      answer = { error: `${error.stack}` };
    } else {
      chip.cutAfterBytes = null;
      answer = { ok: 'power cut' };
    }
  }
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}

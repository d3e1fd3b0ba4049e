// An RP2040 that runs a firmware file: rp2040js, with what it lacks for this project.
//
// - A boot ROM of our own (boot_rom.c), whose flash functions end here, and a flash chip that
//   takes its time, has a serial number and can lose its power in the middle of a write.
// - A USB controller whose packets move when a host asks for them, as on a real bus: rp2040js
//   completes an IN transfer at once, and knows no stall.
// - PIO machines in step with the processor. Between two events of the encoder program is a loop
//   of 7 cycles, so whole turns of it may be left out.
// - What the world puts on a pin is low or nothing, as a contact or an open collector does it: high is
//   what the firmware's pull-up makes of it.
// - The share of time in which a PWM pin is high, from the unit's registers: rp2040js does not move
//   pins in the centred mode.
// - A world that is coupled to it is asked once a PWM period, as the period begins.
import { GPIOPinState, LogLevel, RP2040 } from 'rp2040js';

// The package shows the class of its clock only through a chip.
const Clock = new RP2040().clock.constructor;

const NS_PER_CYCLE = 1e9 / 200e6;
const SECTOR = 4096;
const TYPICAL_ERASE_NS = 45e6; // flash of the Pico; 400 ms at most
const PROGRAM_NS = 0.4e6;
const PIO_LOOP = 7;
const PWM_PERIOD_NS = 25e3;
const PHASES = [0b00, 0b01, 0b11, 0b10]; // A (bit 0) and B, in the order of a turning knob
const TICK_EXCEPTION = 16 + 4; // PWM_IRQ_WRAP
const HARD_FAULT = 3;
const SUPPLY_CHANNEL = 1; // GP27

const BUF_AVAILABLE = 1 << 10;
const BUF_STALL = 1 << 11;
const BUF_FULL = 1 << 15;
const BUF_LENGTH = 0x3ff;
const SIE_SUSPENDED = 1 << 4;
const SIE_RESUME = 1 << 11;
const SIE_SETUP = 1 << 17;
const SIE_RESET = 1 << 19;

export class PowerCut extends Error {}

export class Chip {
  /** @param {{rom: Uint8Array, flash: Uint8Array, serial: Uint8Array}} parts */
  constructor({ rom, flash, serial }) {
    this.rom = rom;
    this.flash = flash;
    this.serial = serial;
    this.cutAfterBytes = null; // power goes after so many bytes of the next flash write
    this.eraseNs = TYPICAL_ERASE_NS;
    this.spoiltByte = null; // of the next page written, this byte fails
    this.watchdogResets = 0;
    this.leastLeft = null; // ns left to the watchdog when it was fed, since watch_feeding
    this.bootloader = false;
    this.lost = false;
    this.low = new Set([11]); // pins that the world connects to ground: the emergency stop runs
    this.zero = 2048; // steps of the current sensor without a current
    this.sensorAmperes = null; // what the sensor shows; null: the truth
    this.motor = { ohm: 2.5, henry: 1.5e-3, supply: 12, voltsPerAmpere: 0.2, divider: 11 };
    this.cut = new Set(); // pins whose wire is cut
    this.instructions = 0;
    this.world = null; // (motor's share, brake's share, enabled) => {amperes, edges}
    this.worldAt = 0; // the next PWM period
    this.edges = []; // edges of the encoder: time and direction
    this.phase = 2;
    this.places = new Map(); // by address
    this.passed = [];
    this.seen = {};
    this.clock = new Clock();
    this.powerUp();
  }

  /** Notes that the program is at a place: registers, and memory that one pointed to at a place. */
  note({ name, pointer, size = 0 }) {
    const registers = Array.from(this.mcu.core.registers.slice(0, 3), (value) => value >>> 0);
    this.seen[name] = registers;
    const at = pointer ? this.seen[pointer[0]][pointer[1]] - 0x20000000 : 0;
    this.passed.push([name, ...registers, Buffer.from(this.mcu.sram.slice(at, at + size)).toString('hex')]);
  }

  powerUp() {
    const clock = new Clock();
    clock.nanosCounter = this.clock.nanosCounter; // the world's time goes on
    this.clock = clock;
    const mcu = new RP2040(clock);
    this.mcu = mcu;
    mcu.logger.currentLogLevel = LogLevel.Error;
    mcu.logger.info = mcu.logger.debug = mcu.logger.warn = () => {};
    mcu.bootrom.set(new Uint32Array(this.rom.buffer));
    mcu.core.reset();
    mcu.flash.set(this.flash);
    mcu.onBreak = (code) => this.trap(code);
    this.flashBusyUntil = 0;
    this.bootloader = false;
    this.sleepless = false;
    this.fitTickMeter();
    this.fitUsb();
    this.fitPins();
    this.fitPio();
    this.fitPwm();
    this.fitFlashChip();
    this.fitWatchdog();
    this.fitResetReason();
    this.fitMotor();
  }

  // Time ----------------------------------------------------------------------------------------

  get ns() {
    return this.clock.nanos;
  }

  /** Runs until the time has come or `done` says so; returns what `done` said. */
  runUntil(ns, done = () => false) {
    while (this.clock.nanos < ns) {
      const { core } = this.mcu;
      if (this.world && this.clock.nanos >= this.nextOfWorld()) this.moveWorld();
      if (core.waiting && this.sleepless) core.waiting = false;
      if (core.waiting) {
        const event = this.world ? Math.min(ns, this.nextOfWorld()) : ns;
        const sleep = Math.min(this.clock.nanosToNextAlarm, event - this.clock.nanos);
        this.pioDebt += sleep / NS_PER_CYCLE;
        this.clock.tick(Math.max(sleep, 1e-3));
      } else {
        const place = this.places.get(core.PC);
        if (place) this.note(place);
        const { entries } = this;
        const cycles = core.executeInstruction();
        // An interrupt came first: the program will be there again.
        if (place && this.entries !== entries) this.passed.pop();
        this.instructions += 1;
        this.pioDebt += cycles;
        this.clock.tick(cycles * NS_PER_CYCLE);
      }
      if (this.restart) {
        this.restart = false;
        this.powerUp();
      }
      if (done()) return true;
    }
    return done();
  }

  /** How long the control interrupt takes, from the processor's point of view. */
  fitTickMeter() {
    const { core } = this.mcu;
    const plain = {
      entry: core.exceptionEntry.bind(core),
      return: core.exceptionReturn.bind(core),
    };
    this.tickNs = { last: 0, most: 0 };
    this.interruptNs = 0; // in all control interrupts
    this.tickInstructions = 0; // the most
    let began = 0;
    let first = 0;
    this.entries = 0;
    core.exceptionEntry = (number) => {
      this.entries += 1;
      if (number === TICK_EXCEPTION) {
        began = this.clock.nanos;
        first = this.instructions;
      }
      plain.entry(number);
    };
    core.exceptionReturn = (value) => {
      if (core.IPSR === TICK_EXCEPTION) {
        const last = this.clock.nanos - began;
        this.tickNs = { last, most: Math.max(last, this.tickNs.most) };
        this.interruptNs += last;
        this.tickInstructions = Math.max(this.tickInstructions, this.instructions - first);
      }
      plain.return(value);
    };
  }

  // The world -----------------------------------------------------------------------------------

  /** Motor and encoder are moved by a world from the next PWM period on. */
  couple(world) {
    this.world = world;
    while (this.worldAt <= this.ns) this.worldAt += PWM_PERIOD_NS;
  }

  nextOfWorld() {
    return Math.min(this.worldAt, this.edges.length > 0 ? this.edges[0].at : Infinity);
  }

  moveWorld() {
    while (this.edges.length > 0 && this.edges[0].at <= this.ns) this.turn(this.edges.shift().step);
    if (this.ns < this.worldAt) return;
    const bridge = (pin) => (this.highShare(pin) ?? 0) - (this.highShare(pin + 1) ?? 0);
    const enabled = this.highShare(10) === 1;
    const { amperes, edges } = this.world(bridge(6), bridge(8), enabled);
    this.amperes = amperes;
    for (const time of edges) {
      this.edges.push({ at: this.worldAt + Math.abs(time), step: Math.sign(time) });
    }
    this.worldAt += PWM_PERIOD_NS;
  }

  /** Turns the encoder by one edge. */
  turn(step, pinA = 2) {
    this.phase = (this.phase + step + 4) % 4;
    this.setPin(pinA, (PHASES[this.phase] & 1) !== 0);
    this.setPin(pinA + 1, (PHASES[this.phase] & 2) !== 0);
  }

  // Ways to go wrong ----------------------------------------------------------------------------

  /**
   * The main loop gets on no more; interrupts do, unless they are masked as well.
   * Or a control interrupt does not, so long after it has begun.
   */
  hang({ masked = false, inside_us: insideUs = null }) {
    const { core, sramView } = this.mcu;
    this.runUntil(this.ns + 1e6, () => core.IPSR === 0);
    if (insideUs !== null) this.runIntoTick(1e3 * insideUs);
    const loop = 0x20040800; // the other core's stack
    sramView.setUint16(loop - 0x20000000, 0xe7fe, true); // b .
    core.PC = loop;
    core.PM = masked;
    core.waiting = false;
  }

  runIntoTick(ns) {
    const { core } = this.mcu;
    let since = this.ns;
    const isThere = () => {
      if (core.IPSR !== TICK_EXCEPTION) since = this.ns;
      return this.ns - since >= ns && core.IPSR === TICK_EXCEPTION;
    };
    if (!this.runUntil(this.ns + 10e6, isThere)) throw new Error('no control interrupt takes so long');
  }

  /** No tick comes any more; the main loop is woken by other things, and often. */
  stopTicks() {
    this.mcu.core.enabledInterrupts &= ~(1 << (TICK_EXCEPTION - 16));
    this.sleepless = true;
  }

  hardFault() {
    const { core } = this.mcu;
    core.exceptionEntry(HARD_FAULT);
    core.waiting = false;
  }

  // Pins ----------------------------------------------------------------------------------------

  /** High means that the world lets go of the pin. */
  setPin(pin, high) {
    if (this.cut.has(pin)) return;
    this.catchUp();
    if (high) this.low.delete(pin);
    else this.low.add(pin);
    this.settle(pin);
  }

  settle(pin) {
    const gpio = this.mcu.gpio[pin];
    gpio.setInputValue(!this.low.has(pin) && gpio.pullupEnabled);
  }

  fitPins() {
    const pads = this.mcu.peripherals[0x4001c];
    const plain = pads.writeUint32.bind(pads);
    pads.writeUint32 = (offset, value) => {
      plain(offset, value);
      const pin = (offset - 4) >> 2;
      if (pin >= 0 && pin < 30) this.settle(pin);
    };
  }

  /** Share of the time in which a pin is driven high, 0 to 1; null if it is not driven. */
  highShare(pin) {
    const gpio = this.mcu.gpio[pin];
    if (gpio.functionSelect === 4) {
      const unit = this.mcu.pwm.channels[(pin >> 1) & 7];
      const level = pin & 1 ? unit.cc >>> 16 : unit.cc & 0xffff;
      const share = Math.min(level / (unit.top + 1), 1);
      const inverted = unit.csr & (pin & 1 ? 8 : 4);
      if (!(unit.csr & 1)) return inverted ? 1 : 0;
      return inverted ? 1 - share : share;
    }
    if (gpio.value === GPIOPinState.High) return 1;
    return gpio.value === GPIOPinState.Low ? 0 : null;
  }

  /** Units in the centred mode stand still: their pins do not move, and their alarms may hang. */
  fitPwm() {
    for (const unit of this.mcu.pwm.channels) {
      const plain = unit.updateEnable.bind(unit);
      unit.updateEnable = () => {
        plain();
        if (unit.csr & 2) unit.timer.enable = false;
      };
    }
    // The running units, after each write that changed them.
    this.pwmStarts = [];
    const { pwm } = this.mcu;
    const write = pwm.writeUint32.bind(pwm);
    let running = 0;
    pwm.writeUint32 = (offset, value) => {
      write(offset, value);
      const now = pwm.channels.reduce((mask, unit) => mask | ((unit.csr & 1) << unit.index), 0);
      if (now !== running) this.pwmStarts.push(now);
      if (now & ~running) this.worldAt = this.clock.nanos + PWM_PERIOD_NS;
      running = now;
    };
  }

  fitPio() {
    const pio = this.mcu.pio[0];
    this.pioDebt = 0;
    pio.run = () => {
      this.pioDebt = 0;
    };
    for (const name of ['readUint32', 'writeUint32']) {
      const plain = pio[name].bind(pio);
      pio[name] = (...words) => {
        this.catchUp();
        return plain(...words);
      };
    }
  }

  catchUp() {
    const pio = this.mcu.pio[0];
    let cycles = Math.floor(this.pioDebt);
    this.pioDebt -= cycles;
    if (pio.stopped) return;
    if (cycles > 8 * PIO_LOOP) {
      cycles = 4 * PIO_LOOP + (cycles % PIO_LOOP);
    }
    for (; cycles > 0; --cycles) pio.step();
  }

  /** The motor's winding between its PWM pins (6 and 7), its current sensor, and a divider at the supply. */
  fitMotor() {
    const { adc } = this.mcu;
    this.amperes = 0;
    let last = this.clock.nanos;
    const plain = adc.onADCRead;
    adc.onADCRead = (channel) => {
      const { ohm, henry, supply, voltsPerAmpere, divider } = this.motor;
      if (channel === SUPPLY_CHANNEL) {
        adc.channelValues[channel] = Math.min(4095, Math.round((supply / divider / 3.3) * 4096));
        plain(channel);
        return;
      }
      if (!this.world) {
        const seconds = (this.clock.nanos - last) * 1e-9;
        last = this.clock.nanos;
        const share = this.mcu.gpio[10].value === GPIOPinState.High ? this.highShare(6) - this.highShare(7) : 0;
        const end = (supply * share) / ohm;
        this.amperes = end + (this.amperes - end) * Math.exp((-seconds * ohm) / henry);
      }
      const seen = this.sensorAmperes ?? this.amperes;
      const steps = Math.round(this.zero + ((seen * voltsPerAmpere) / 3.3) * 4096);
      adc.channelValues[0] = Math.max(0, Math.min(4095, steps));
      plain(channel);
    };
  }

  // Flash ---------------------------------------------------------------------------------------

  trap(code) {
    const r = this.mcu.core.registers;
    switch (code) {
      case 1:
        this.changeFlash(r[0] >>> 0, new Uint8Array(r[1] >>> 0).fill(0xff), this.eraseNs);
        break;
      case 2: {
        const at = (r[1] >>> 0) - 0x20000000;
        const to = r[0] >>> 0;
        const data = this.mcu.sram.slice(at, at + (r[2] >>> 0));
        // Programming can only clear bits.
        const bytes = data.map((byte, i) => byte & this.flash[to + i]);
        if (this.spoiltByte !== null) bytes[this.spoiltByte] ^= 0x10;
        this.spoiltByte = null;
        this.changeFlash(to, bytes, PROGRAM_NS);
        break;
      }
      case 3:
        r[0] = this.clock.nanos < this.flashBusyUntil ? 1 : 0;
        break;
      case 4:
        this.bootloader = true;
        this.stopWatchdog(); // the real one begins with a reset, which does
        break;
      case 5:
        this.commandMode = true;
        this.answers = [];
        this.sent = [];
        break;
      case 6:
        this.commandMode = false;
        break;
      default:
        this.lost = true;
    }
  }

  changeFlash(address, bytes, ns) {
    const cut = this.cutAfterBytes;
    const part = cut === null ? bytes : bytes.subarray(0, Math.min(cut, bytes.length));
    this.flash.set(part, address);
    this.mcu.flash.set(part, address);
    this.flashBusyUntil = this.clock.nanos + ns * (bytes.length / (bytes.length > 256 ? SECTOR : 256));
    if (cut !== null) {
      this.cutAfterBytes = cut - part.length;
      if (part.length < bytes.length) throw new PowerCut();
    }
  }

  /** Answers the command for the flash chip's serial number, which the SDK asks for directly. */
  fitFlashChip() {
    const ssi = this.mcu.peripherals[0x18000];
    const plain = { read: ssi.readUint32.bind(ssi), write: ssi.writeUint32.bind(ssi) };
    ssi.writeUint32 = (offset, value) => {
      if (offset !== 0x60 || !this.commandMode) return plain.write(offset, value);
      const place = this.sent.push(value & 0xff) - 1;
      this.answers.push(this.sent[0] === 0x4b && place >= 5 ? this.serial[place - 5] : 0);
    };
    ssi.readUint32 = (offset) =>
      offset === 0x60 && this.commandMode ? (this.answers.shift() ?? 0) : plain.read(offset);
  }

  fitWatchdog() {
    const watchdog = Object.values(this.mcu.peripherals).find((p) => p.name === 'WATCHDOG_BASE');
    const write = watchdog.writeUint32.bind(watchdog);
    let bitesAt = null;
    watchdog.writeUint32 = (offset, value) => {
      if (offset === 4) {
        const left = bitesAt === null ? Infinity : bitesAt - this.ns;
        this.leastLeft = Math.min(this.leastLeft ?? Infinity, left);
        bitesAt = this.ns + (value & 0xffffff) * 500; // it counts two a microsecond
      }
      write(offset, value);
    };
    watchdog.onWatchdogTrigger = () => {
      watchdog.alarm.enable = false; // or it would come again at the same moment, for ever
      this.watchdogResets += 1;
      this.watchdogBit = true;
      this.scratch = watchdog.scratchData;
      this.restart = true;
    };
  }

  /** The boot ROM has the watchdog start a file that it was given, and says so in a register. */
  startCopied() {
    const watchdog = Object.values(this.mcu.peripherals).find((p) => p.name === 'WATCHDOG_BASE');
    this.watchdogBit = true;
    this.scratch = watchdog.scratchData;
    this.scratch[4] = 0;
    this.powerUp();
  }

  stopWatchdog() {
    const watchdog = Object.values(this.mcu.peripherals).find((p) => p.name === 'WATCHDOG_BASE');
    watchdog.alarm.enable = false;
  }

  /** What the chip remembers of its last reset: the watchdog keeps its scratch registers. */
  fitResetReason() {
    const watchdog = Object.values(this.mcu.peripherals).find((p) => p.name === 'WATCHDOG_BASE');
    if (this.watchdogBit) {
      watchdog.reason = 1;
      watchdog.scratchData.set(this.scratch);
    }
    const bitten = this.watchdogBit;
    this.watchdogBit = false;
    this.mcu.peripherals[0x40064].readUint32 = (offset) => (offset === 8 && !bitten ? 1 << 8 : 0);
  }

  // USB: what a host sees ------------------------------------------------------------------------

  fitUsb() {
    const usb = this.mcu.usbCtrl;
    usb.DPRAMUpdated = () => {}; // buffers move in token()
    const write = usb.writeUint32.bind(usb);
    usb.writeUint32 = (offset, value) => {
      if (offset === 0x50 && usb.rawWriteValue & SIE_SUSPENDED) usb.sieStatus &= ~SIE_SUSPENDED;
      write(offset, value);
    };
  }

  signal(bit) {
    this.mcu.usbCtrl.sieStatus |= bit;
    this.mcu.usbCtrl.sieStatusUpdated();
  }
  busReset() {
    this.signal(SIE_RESET);
  }
  suspend() {
    this.signal(SIE_SUSPENDED);
  }
  resume() {
    this.signal(SIE_RESUME);
  }

  get attached() {
    return (this.mcu.usbCtrl.sieCtrl & (1 << 16)) !== 0;
  }

  setup(bytes) {
    const { usbDPRAM, usbDPRAMView, usbCtrl } = this.mcu;
    usbCtrl.epStallArm = 0;
    for (const out of [0, 4]) usbDPRAMView.setUint32(0x80 + out, 0, true);
    usbDPRAM.set(bytes, 0);
    this.signal(SIE_SETUP);
  }

  /** One IN (data === null) or OUT token: 'nak', 'stall', the data read, or true for data taken. */
  token(endpoint, data) {
    const { usbDPRAM, usbDPRAMView, usbCtrl } = this.mcu;
    const out = data !== null;
    const register = 0x80 + 8 * endpoint + (out ? 4 : 0);
    const control = usbDPRAMView.getUint32(register, true);
    const armed = endpoint !== 0 || (usbCtrl.epStallArm & (out ? 2 : 1)) !== 0;
    if (control & BUF_STALL && armed) return 'stall';
    if (!(control & BUF_AVAILABLE)) return 'nak';
    if (out === Boolean(control & BUF_FULL)) return 'nak';
    const at = usbCtrl.getEndpointBufferOffset(endpoint, out);
    const length = out ? data.length : control & BUF_LENGTH;
    if (out) usbDPRAM.set(data, at);
    const kept = control & ~(BUF_AVAILABLE | BUF_FULL | BUF_LENGTH);
    usbDPRAMView.setUint32(register, kept | (out ? BUF_FULL : 0) | length, true);
    const read = usbDPRAM.slice(at, at + length);
    usbCtrl.indicateBufferReady(endpoint, out);
    return out ? true : read;
  }
}

// The emulated device: the firmware's own code and the physics, compiled to WebAssembly.

interface Exports {
  memory: WebAssembly.Memory;
  _initialize?(): void;
  start(seed: number, controlPeriodNs: number): void;
  report_buffer(): number;
  knot_buffer(): number;
  write_report(): number;
  read_report(): number;
  get_feature(id: number): number;
  set_feature(): number;
  add_to_scene(): void;
  swing_warning(controlPeriodNs: number): number;
  advance(durationNs: number): void;
  time_ns(): number;
  let_go(): void;
  hold_softly(inertia: number, stiffness: number, damping: number, knots: number): void;
  push(knots: number): void;
  set_emergency_stop(pressed: number): void;
  take_truth(): number;
  thrown_text(): number;
}

/** A path's corner: time in s from when the hand takes over, and value. */
export type Knot = readonly [number, number];

/** Names of the columns of `truth`, in order. */
export const TRUTH = [
  "angle_rad", "brake_angle_rad", "speed_rad_s", "spring_torque_nm", "brake_torque_nm",
  "brake_capacity_nm", "motor_torque_nm", "hand_torque_nm", "knob_friction_torque_nm",
] as const;

export class EmulatedDevice {
  private constructor(private readonly wasm: Exports) {}

  /** @param controlPeriodNs 50,000 to 1,000,000 */
  static async load(module: BufferSource | WebAssembly.Module, seed = 0, controlPeriodNs = 250_000): Promise<EmulatedDevice> {
    const compiled = module instanceof WebAssembly.Module ? module : await WebAssembly.compile(module);
    // It asks nothing of an operating system; what its libraries import is never of use.
    const imports: WebAssembly.Imports = {};
    for (const { module, name } of WebAssembly.Module.imports(compiled)) {
      const of = (imports[module] ??= {}) as Record<string, () => number>;
      of[name] = () => {
        if (name === "proc_exit") throw new Error("the emulated device stopped: bad arguments");
        return 52; // not supported
      };
    }
    const instance = await WebAssembly.instantiate(compiled, imports);
    const device = new EmulatedDevice(instance.exports as unknown as Exports);
    device.wasm._initialize?.();
    device.#run(() => device.wasm.start(seed, controlPeriodNs));
    return device;
  }

  /** @throws Error with the device's own words; the device cannot be used any more */
  #run<T>(call: () => T): T {
    try {
      return call();
    } catch (error) {
      const text = this.#text(this.wasm.thrown_text());
      throw text ? new Error(text) : error;
    }
  }

  #text(at: number): string {
    const bytes = new Uint8Array(this.wasm.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  // Memory may have grown, so these are made anew each time.
  private buffer(): Uint8Array {
    return new Uint8Array(this.wasm.memory.buffer, this.wasm.report_buffer(), 64);
  }

  private knots(path: readonly Knot[]): number {
    const most = 256;
    new Float64Array(this.wasm.memory.buffer, this.wasm.knot_buffer(), 2 * most).set(
      path.slice(0, most).flat(),
    );
    return Math.min(path.length, most);
  }

  /** @returns false if the queue is full: let a millisecond pass */
  write(report: Uint8Array): boolean {
    this.buffer().set(report);
    return this.wasm.write_report() !== 0;
  }

  read(): Uint8Array | undefined {
    return this.wasm.read_report() ? this.buffer().slice() : undefined;
  }

  getFeature(id: number): Uint8Array | undefined {
    return this.wasm.get_feature(id) === 0 ? this.buffer().slice() : undefined;
  }

  setFeature(report: Uint8Array): boolean {
    this.buffer().set(report);
    return this.wasm.set_feature() === 0;
  }

  /** A sentence if a knob may swing or hum in a scene; "" if it comes to rest.
   * @param reports of the scene, and the configurations of actuator and control */
  swingWarning(reports: readonly Uint8Array[], controlPeriodNs: number): string {
    for (const report of reports) {
      this.buffer().set(report);
      this.wasm.add_to_scene();
    }
    return this.#text(this.wasm.swing_warning(controlPeriodNs));
  }

  /** Lets time pass. */
  advance(durationNs: number): void {
    this.#run(() => this.wasm.advance(durationNs));
  }

  get timeNs(): number {
    return this.wasm.time_ns();
  }

  /** A hand that means to move the knob along a path. */
  hold(inertia: number, stiffness: number, damping: number, path: readonly Knot[]): void {
    this.#run(() => this.wasm.hold_softly(inertia, stiffness, damping, this.knots(path)));
  }

  /** A torque on the knob. */
  push(path: readonly Knot[]): void {
    this.#run(() => this.wasm.push(this.knots(path)));
  }

  letGo(): void {
    this.wasm.let_go();
  }

  setEmergencyStop(pressed: boolean): void {
    this.wasm.set_emergency_stop(pressed ? 1 : 0);
  }

  /** True values that no sensor sees; the columns are TRUTH. */
  truth(): number[] {
    const at = this.wasm.take_truth();
    return [...new Float64Array(this.wasm.memory.buffer, at, TRUTH.length)];
  }
}

// The way to a knob: four calls that move whole reports, whatever carries them.

import { REPORT_SIZE } from "./codec";

/** The world round an emulated knob. */
export interface World {
  /** Of this moment, as `TRUTH` names it; empty until it is known. */
  readonly truth: readonly number[];
  /** The hand means to turn the knob so far from where it took it; undefined lets go. */
  hand(turned: number | undefined): void;
  setEmergencyStop(pressed: boolean): void;
}

export interface Transport {
  /** What the page calls it. */
  readonly title: string;
  /** Only an emulated knob has one. */
  readonly world?: World;
  /** Only looks: nothing that is written arrives. */
  readonly readOnly?: boolean;
  /** Sends an output report; resolves when it is on its way. @throws Gone */
  write(report: Uint8Array): Promise<void>;
  /** Waits for input reports and gives all that have come, oldest first. @throws Gone */
  read(): Promise<Uint8Array[]>;
  /** Asks for a feature report; undefined: the device stalled the request. @throws Gone */
  getFeature(id: number): Promise<Uint8Array | undefined>;
  /** Sends a feature report; false: the device stalled the request. @throws Gone */
  setFeature(report: Uint8Array): Promise<boolean>;
  close(): void;
}

/** The device is not there any more; the text says what happened and what to do. */
export class Gone extends Error {}

/** Reports that stand one behind the other. */
export function reportsIn(bytes: Uint8Array): Uint8Array[] {
  const reports: Uint8Array[] = [];
  for (let at = 0; at < bytes.length; at += REPORT_SIZE) reports.push(bytes.subarray(at, at + REPORT_SIZE));
  return reports;
}

/** Input reports between the one who brings them and the one who reads. */
export class Inbox {
  #reports: Uint8Array[] = [];
  #why: string | undefined;
  #wake: (() => void) | undefined;

  push(reports: Uint8Array[]): void {
    this.#reports.push(...reports);
    if (this.#reports.length) this.#wake?.();
  }

  /** Reports that have arrived can still be read. */
  end(why: string): void {
    this.#why ??= why;
    this.#wake?.();
  }

  check(): void {
    if (this.#why !== undefined) throw new Gone(this.#why);
  }

  async take(): Promise<Uint8Array[]> {
    while (!this.#reports.length) {
      this.check();
      await new Promise<void>((resolve) => (this.#wake = resolve));
      this.#wake = undefined;
    }
    const taken = this.#reports;
    this.#reports = [];
    return taken;
  }
}

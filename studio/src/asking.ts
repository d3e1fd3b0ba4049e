// Asks a device for its feature reports, and who it is.

import { decode, MalformedReport, REPORT_SIZE, type Values } from "./codec";
import { FINGERPRINT, RELEASED_FINGERPRINTS, REPORTS } from "./reports";
import type { Units } from "./samples";
import type { Transport } from "./transport";

export const LOOK_MS = 1000;
// Looks without an answer before a timeout; a busy machine needs some.
const ANSWER_LOOKS = 5;
export const IN_TIME = `within ${(ANSWER_LOOKS * LOOK_MS) / 1000} s`;
export const CABLE = "try another cable and another port, without a hub";

export interface Identity extends Units {
  serial: string;
  firmware: string;
  board: number;
  effects: number;
  curvePoints: number;
}

/**
 * Calls when no answer came for too long. Looks are counted and not time: a page that stood still has had no answer
 * either.
 * @returns to be called when it came
 */
export function whenSilent(call: () => void): () => void {
  let looks = 0;
  const timer = setInterval(() => {
    if (++looks < ANSWER_LOOKS) return;
    clearInterval(timer);
    call();
  }, LOOK_MS);
  return () => clearInterval(timer);
}

/** A feature report of the right length. @throws Error that says what is wrong */
export async function ask(transport: Transport, name: string): Promise<Uint8Array> {
  let given = (): void => {};
  const silence = new Promise<never>((_, reject) => {
    given = whenSilent(() => reject(new Error(`the device did not give its ${name} report ${IN_TIME}: ${CABLE}`)));
  });
  try {
    const report = await Promise.race([transport.getFeature(REPORTS[name]!.id), silence]);
    if (!report) throw new Error(`the device does not give its ${name} report: is it a Torsio knob?`);
    if (report.length !== REPORT_SIZE) {
      throw new Error(`the device's ${name} report has ${report.length} bytes in place of ${REPORT_SIZE}: ${CABLE}`);
    }
    return report;
  } finally {
    given();
  }
}

function understood(report: Uint8Array, wanted: string): Values {
  try {
    const { name, values } = decode(report);
    if (name !== wanted) throw new Error(`the device gave its ${name} report in place of ${wanted}: ${CABLE}`);
    return values;
  } catch (error) {
    if (!(error instanceof MalformedReport)) throw error;
    throw new Error(`the device's ${wanted} report makes no sense (${error.message}): ${CABLE}`);
  }
}

export async function feature(transport: Transport, name: string): Promise<Values> {
  return understood(await ask(transport, name), name);
}

export async function identify(transport: Transport): Promise<Identity> {
  const report = await ask(transport, "identity");
  // These two are the same in every version, whatever comes behind them.
  const view = new DataView(report.buffer, report.byteOffset);
  if (![FINGERPRINT, ...RELEASED_FINGERPRINTS].includes(view.getUint32(1, true))) {
    throw new Error(
      `the device speaks another protocol (version ${view.getUint16(5, true)}, fingerprint ` +
        `0x${view.getUint32(1, true).toString(16)}) than this page: give both the same version of Torsio`,
    );
  }
  const values = understood(report, "identity");
  const serial = (values.serial as number[]).filter((c) => c > 0);
  return {
    serial: String.fromCharCode(...serial),
    firmware: (values.firmware_version as number[]).join("."),
    board: Number(values.board),
    effects: Number(values.effects),
    curvePoints: Number(values.curve_points),
    controlPeriodNs: Number(values.control_period_ns),
    countsPerRev: Number(values.counts_per_rev),
    torqueStepNm: Number(values.torque_step_nm),
    speedStepRadS: Number(values.speed_step_rad_s),
  };
}

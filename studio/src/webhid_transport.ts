// A knob on this computer, real or virtual, over WebHID.

import rules from "../../sdk/60-torsio.rules";
import { REPORT_SIZE } from "./codec";
import { USB } from "./reports";
import { Gone, Inbox, type Transport } from "./transport";

const CONTROL_USAGE_PAGE = 0xff00;
const UDEV_RULE = rules.split("\n").find((line) => line.includes('"hidraw"')) ?? "";
const UDEV_HELP =
  "the browser may not open the knob. On Linux a udev rule allows it: put this line into " +
  "/etc/udev/rules.d/60-torsio.rules, then unplug the knob and plug it in again (./dev udev does it)";

export function hasWebHid(): boolean {
  return "hid" in navigator;
}

export class WebHidTransport implements Transport {
  readonly title: string;
  readonly #device: HIDDevice;
  readonly #inbox = new Inbox();
  readonly #gone = (event: HIDConnectionEvent): void => {
    if (event.device === this.#device) this.#inbox.end("the knob was unplugged; plug it in again");
  };

  private constructor(device: HIDDevice) {
    this.#device = device;
    this.title = device.productName || "knob";
    device.oninputreport = ({ reportId, data }) => {
      const report = new Uint8Array(REPORT_SIZE);
      report[0] = reportId;
      report.set(new Uint8Array(data.buffer, data.byteOffset, data.byteLength).subarray(0, 63), 1);
      this.#inbox.push([report]);
    };
    navigator.hid.addEventListener("disconnect", this.#gone);
  }

  /**
   * Asks the user which knob, unless only one can be meant; needs a click.
   * @param another whether to ask again, because the user may want another knob
   * @throws Error that says what to do
   */
  static async open(another: boolean): Promise<WebHidTransport> {
    const own = (device: HIDDevice): boolean =>
      device.vendorId === USB.vendorId &&
      device.productId === USB.productId &&
      device.collections.some((c) => (c.usagePage ?? 0) >= CONTROL_USAGE_PAGE);
    const allowed = (await navigator.hid.getDevices()).filter(own);
    const device = allowed.length === 1 && !another
      ? allowed[0]
      : (await navigator.hid.requestDevice({ filters: [USB] })).filter(own)[0];
    if (!device) throw new Error("no knob was chosen");
    try {
      if (!device.opened) await device.open();
    } catch (error) {
      throw new Error(`${UDEV_HELP}:\n\n${UDEV_RULE}\n\n(${String(error)})`);
    }
    return new WebHidTransport(device);
  }

  async #carefully<T>(use: () => Promise<T>): Promise<T> {
    this.#inbox.check();
    try {
      return await use();
    } catch (error) {
      if (!this.#device.opened) throw new Gone("the knob is gone; plug it in again");
      throw error;
    }
  }

  async write(report: Uint8Array): Promise<void> {
    await this.#carefully(() => this.#device.sendReport(report[0]!, report.slice(1)));
  }

  read(): Promise<Uint8Array[]> {
    return this.#inbox.take();
  }

  async getFeature(id: number): Promise<Uint8Array | undefined> {
    try {
      const data = await this.#carefully(() => this.#device.receiveFeatureReport(id));
      const report = new Uint8Array(REPORT_SIZE);
      // Some systems give the id in front, as hidraw does.
      const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
      report.set(bytes.length >= REPORT_SIZE ? bytes.subarray(0, REPORT_SIZE) : bytes, bytes.length >= REPORT_SIZE ? 0 : 1);
      report[0] = id;
      return report;
    } catch (error) {
      if (error instanceof Gone) throw error;
      return undefined;
    }
  }

  async setFeature(report: Uint8Array): Promise<boolean> {
    try {
      await this.#carefully(() => this.#device.sendFeatureReport(report[0]!, report.slice(1)));
      return true;
    } catch (error) {
      if (error instanceof Gone) throw error;
      return false;
    }
  }

  close(): void {
    navigator.hid.removeEventListener("disconnect", this.#gone);
    this.#inbox.end("the knob was closed");
    void this.#device.close();
  }
}

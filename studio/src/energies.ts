// Counts of the law `calibrated`: energies of motor, shaft and brake, and the stiffest wall that it renders now.

import type { Values } from "./codec";
import type { Knob } from "./knob";
import { show } from "./page";
import { LEDGER_TORQUE_NM } from "./reports";

const LOOK_MS = 500;
// A law without energies is asked less often; another program may change the law.
const IDLE_LOOKS = 4;

export interface Energies {
  /** Given to the knob by the motor. */
  motorJ: number;
  /** By motor and shaft together, which a hand feels. */
  feltJ: number;
  /** In the shaft's spring now. */
  storedJ: number;
  /** Taken by the brake. */
  brakeJ: number;
}

/** The device's ledger in joules; motor = felt + stored + brake. */
export function energiesOf(ledger: Values, countsPerRev: number): Energies {
  const stepJ = (LEDGER_TORQUE_NM * 2 * Math.PI) / countsPerRev;
  const motorJ = Number(ledger.motor) * stepJ, springJ = (Number(ledger.spring_twice) / 2) * stepJ;
  const storedJ = Number(ledger.stored_j);
  return { motorJ, feltJ: motorJ + springJ, storedJ, brakeJ: -springJ - storedJ };
}

/** Shows them, if the law counts. */
export class EnergyReadouts {
  #idle = 0;

  constructor(private readonly knob: () => Knob | undefined) {
    setInterval(() => void this.#look(), LOOK_MS);
  }

  async #look(): Promise<void> {
    const knob = this.knob();
    if (!knob || knob.state === "disconnected") return this.#hide(true);
    if (this.#idle > 0 && --this.#idle > 0) return;
    try {
      const ledger = await knob.read("ledger");
      if (knob === this.knob()) this.#show(ledger, knob.identity.countsPerRev);
    } catch {
      // The reader of telemetry says that the knob is gone.
    }
  }

  #show(ledger: Values, countsPerRev: number): void {
    const isKept = ledger.kept === "on", bound = Number(ledger.bound_nm_per_rad);
    this.#idle = isKept ? 0 : IDLE_LOOKS;
    this.#hide(!isKept);
    if (!isKept) return;
    const energies = energiesOf(ledger, countsPerRev);
    for (const [id, value] of [
      ["motor_j", energies.motorJ], ["felt_j", energies.feltJ], ["stored_j", energies.storedJ], ["brake_j", energies.brakeJ],
    ] as const) show(id, value, `${(1e3 * value).toFixed(2)} mJ`);
    show("bound_nm_per_rad", bound, bound ? `${bound.toFixed(2)} N·m/rad` : "as asked");
  }

  #hide(isHidden: boolean): void {
    document.body.classList.toggle("counts-energy", !isHidden);
  }
}

// The emulator, for programs in other folders too: packages are found from the file that asks.
export * from 'rp2040js';

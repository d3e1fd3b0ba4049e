// The text of a file that the user gives.

// No file that the page reads has more than some kB.
const MOST_BYTES = 2 ** 20;

/** PowerShell's redirection writes UTF-16, with a mark in front; not every browser's `text()` reads it. */
export async function textOf(file: Blob): Promise<string> {
  if (file.size > MOST_BYTES) throw new RangeError(`the file has ${file.size} bytes; a configuration has at most ${MOST_BYTES}`);
  const content = await file.arrayBuffer();
  const [first, second] = new Uint8Array(content);
  const wide = first === 0xff && second === 0xfe ? "utf-16le" : first === 0xfe && second === 0xff && "utf-16be";
  return new TextDecoder(wide || "utf-8").decode(content);
}

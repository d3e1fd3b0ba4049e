// The text of a file that the user gives.

/** PowerShell's redirection writes UTF-16, with a mark in front; not every browser's `text()` reads it. */
export async function textOf(file: Blob): Promise<string> {
  const content = await file.arrayBuffer();
  const [first, second] = new Uint8Array(content);
  const wide = first === 0xff && second === 0xfe ? "utf-16le" : first === 0xfe && second === 0xff && "utf-16be";
  return new TextDecoder(wide || "utf-8").decode(content);
}

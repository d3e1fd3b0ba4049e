// Files that the user gives, in the encodings that programs write.

import assert from "node:assert/strict";
import { test } from "node:test";

import { textOf } from "../../build/studio/modules/text_file.js";

test("a mark in front says how the text is encoded", async () => {
  const files = {
    "none": [0x7b, 0x7d],
    "UTF-8": [0xef, 0xbb, 0xbf, 0x7b, 0x7d],
    "UTF-16, little end first": [0xff, 0xfe, 0x7b, 0x00, 0x7d, 0x00],
    "UTF-16, big end first": [0xfe, 0xff, 0x00, 0x7b, 0x00, 0x7d],
  };
  for (const [name, bytes] of Object.entries(files)) assert.equal(await textOf(new Blob([Uint8Array.from(bytes)])), "{}", name);
});

test("a file that would fill the memory is refused", async () => {
  await assert.rejects(textOf({ size: 2 ** 40 }), /bytes; a configuration has at most/);
});

"""Recordings as other programs see them: schemas and messages held to the standards."""

from __future__ import annotations

import json
import subprocess
from collections import Counter
from pathlib import Path

from jsonschema import Draft202012Validator
from mcap.reader import make_reader
from mcap.well_known import MessageEncoding, SchemaEncoding

TREE = Path(__file__).parent.parent
CHECKED = 100
# Foxglove's own reader of MCAP. It checks the sums of chunks, data and summary.
_FOXGLOVE = """
import { createRequire } from "node:module";
import { open } from "node:fs/promises";
const { McapIndexedReader } = createRequire(process.argv[1])("@mcap/core");
const file = await open(process.argv[2]);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, size) => {
    const bytes = new Uint8Array(Number(size));
    await file.read(bytes, 0, bytes.length, Number(offset));
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({ readable });
const topic = (id) => reader.channelsById.get(id).topic;
const sizes = [...reader.statistics.channelMessageCounts];
const counted = () => Object.fromEntries(sizes.map(([id, count]) => [topic(id), Number(count)]));
// The viewer brings zstd along; here the index has to do where chunks are compressed.
if (reader.chunkIndexes.every(({ compression }) => compression === "")) {
  const left = counted();
  for await (const { channelId } of reader.readMessages()) --left[topic(channelId)];
  if (Object.values(left).some((count) => count !== 0)) throw new Error("the index is wrong");
}
console.log(JSON.stringify(counted()));
await file.close();
"""


def check_recording(file: Path) -> Counter[str]:
    """Hold a file to the rules of MCAP and JSON Schema; gives how many messages a topic has."""
    validators: dict[str, Draft202012Validator] = {}
    counts: Counter[str] = Counter()
    with file.open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            assert schema is not None
            if channel.topic not in validators:
                assert schema.encoding == SchemaEncoding.JSONSchema
                assert channel.message_encoding == MessageEncoding.JSON
                described = json.loads(schema.data)
                Draft202012Validator.check_schema(described)
                validators[channel.topic] = Draft202012Validator(described)
            counts[channel.topic] += 1
            # All of them would take seconds and be of the same kind.
            if counts[channel.topic] <= CHECKED:
                validators[channel.topic].validate(json.loads(message.data))
    return counts


def counts_in_foxglove(file: Path) -> dict[str, int]:
    """Open a file with the library of Foxglove's viewer; gives messages by topic."""
    done = subprocess.run(
        ["node", "--input-type=module", "-e", _FOXGLOVE, TREE / "studio/package.json", file],
        capture_output=True,
        text=True,
        check=True,
    )
    counts: dict[str, int] = json.loads(done.stdout)
    return counts

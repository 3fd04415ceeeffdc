"""Reads a recording with the mcap package of PyPI: every channel, its schema, every message as JSON."""

import json
import sys
from collections import Counter

from mcap.reader import make_reader

messages, frames = Counter(), 0
with open(sys.argv[1], "rb") as file:
    reader = make_reader(file, validate_crcs=True)
    summary = reader.get_summary()
    for schema in summary.schemas.values():
        assert schema.encoding == "jsonschema", schema.encoding
        assert json.loads(schema.data)["type"] == "object"
    for schema, channel, message in reader.iter_messages():
        body = json.loads(message.data)
        assert channel.message_encoding == "json" and schema.name.startswith("gelpad.")
        assert set(body) <= set(json.loads(schema.data)["properties"]), (channel.topic, body)
        messages[channel.topic] += 1
        if channel.topic == "/frames":
            frames += 1 + len(body["dt_ns"])
    attachments = sorted(attachment.name for attachment in reader.iter_attachments())
for topic, count in sorted(messages.items()):
    print(topic, count)
print("frames", frames)
print("attachments", *attachments)

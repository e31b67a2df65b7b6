"""A run log as the official MCAP packages give it: all of it in memory, messages by topic."""

from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


class Message(NamedTuple):
    """A decoded message, and the times of its record."""

    body: object
    sequence: int
    log_time: int
    publish_time: int


class LogFile:
    def __init__(self, path: Path):
        with path.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            self.summary = reader.get_summary()
            self.attachments = {each.name: each for each in reader.iter_attachments()}
            self.metadata = {each.name: each.metadata for each in reader.iter_metadata()}
            self.messages = defaultdict(list)
            for _, channel, message, body in reader.iter_decoded_messages(log_time_order=False):
                record = Message(body, message.sequence, message.log_time, message.publish_time)
                self.messages[channel.topic].append(record)

    def cycles(self, topic: str) -> list:
        """The messages of a topic that has one for each cycle, in the order of the cycles."""
        return sorted(self.messages[topic], key=lambda message: message.sequence)

"""Topics, schemas, index, metadata and attachments are those that docs/recording.md promises."""

from pathlib import Path

from log_file import LogFile

SCHEMAS = {
    "/joint_states": "foxglove.JointStates",
    "/tf": "foxglove.FrameTransforms",
    "/scene": "foxglove.SceneUpdate",
    "/log": "foxglove.Log",
    "/control": "uarm.ControlSample",
    "/timing": "uarm.LoopTiming",
    "/drives": "uarm.DriveStates",
    "/can/frames": "uarm.CanFrame",
    "/can/health": "uarm.CanHealth",
    "/keyframes": "uarm.Keyframe",
    "/fault": "uarm.Fault",
}
METADATA = {"uarm.run", "uarm.robot", "uarm.machine", "uarm.drives", "uarm.end"}
# Attachments, and the files of the repository that they are; the robot file is compared where it is known.
ATTACHMENTS = {"robot.toml": None, "uarm.dbc": "crates/uarm-io/wire/uarm.dbc", "uarm-drive.eds": "crates/uarm-io/wire/uarm-drive.eds"}
# The drives are stopped within this time of the last cycle.
STOP_NS = 5_000_000_000


def check(log: LogFile) -> str:
    check_topics(log)
    check_index(log)
    check_times(log)
    assert set(log.metadata) == METADATA, f"metadata {sorted(log.metadata)}"
    assert set(log.attachments) == set(ATTACHMENTS), f"attachments {sorted(log.attachments)}"
    for name, file in ATTACHMENTS.items():
        assert file is None or log.attachments[name].data == Path(file).read_bytes(), f"attached {name} is not {file}"
    total = sum(map(len, log.messages.values()))
    return f"{total} messages on {len(log.messages)} topics, {len(METADATA)} metadata, {len(ATTACHMENTS)} attachments"


def check_topics(log: LogFile) -> None:
    schemas, channels = log.summary.schemas, log.summary.channels.values()
    found = {channel.topic: schemas[channel.schema_id].name for channel in channels}
    assert found == SCHEMAS, f"topics {found}"
    for channel in channels:
        encodings = channel.message_encoding, schemas[channel.schema_id].encoding
        assert encodings == ("protobuf", "protobuf"), f"{channel.topic}: {encodings}"
    expected = set(SCHEMAS) if log.metadata["uarm.end"]["fault"] else set(SCHEMAS) - {"/fault"}
    assert set(log.messages) == expected, f"topics with messages: {sorted(log.messages)}"


def check_index(log: LogFile) -> None:
    """The index at the end of the file counts what reading it through gives."""
    statistics = log.summary.statistics
    topics = {number: channel.topic for number, channel in log.summary.channels.items()}
    counted = {topics[number]: count for number, count in statistics.channel_message_counts.items() if count}
    found = {topic: len(messages) for topic, messages in log.messages.items()}
    assert counted == found, f"the index counts {counted}, the file holds {found}"
    assert len(log.summary.chunk_indexes) == statistics.chunk_count > 1, f"{statistics.chunk_count} chunks"


def check_times(log: LogFile) -> None:
    start = log.attachments["robot.toml"].log_time
    end = max(message.body.done_ns for message in log.messages["/timing"]) + STOP_NS
    for topic, messages in log.messages.items():
        for message in messages:
            assert start <= message.log_time <= end, f"{topic}: {message.log_time} is not in {start}..{end}"

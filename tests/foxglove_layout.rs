//! The Foxglove layout shows what is in a log: each panel is placed once, and each message path in it names a topic, fields
//! and elements that a recorded run has.

use mcap::MessageStream;
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FileDescriptorSet};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use uarm::robot::Robot;
use uarm_log::topic::Topic;

fn layout() -> Value {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/foxglove/uarm-layout.json");
    serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap()
}

/// The identifiers of the panels in a mosaic.
fn placed(node: &Value, panels: &mut Vec<String>) {
    match node {
        Value::String(panel) => panels.push(panel.clone()),
        node => {
            assert!(matches!(node["direction"].as_str(), Some("row" | "column")), "{node}");
            placed(&node["first"], panels);
            placed(&node["second"], panels);
        }
    }
}

/// Message paths of all panels.
fn paths(layout: &Value) -> Vec<String> {
    let mut paths = Vec::new();
    for config in layout["configById"].as_object().unwrap().values() {
        let series = config["paths"].as_array().into_iter().flatten();
        paths.extend(series.map(|series| series["value"].as_str().unwrap().to_owned()));
        paths.extend(["topicToRender", "topicPath"].iter().filter_map(|key| config[key].as_str()).map(str::to_owned));
        let topics = config["topics"].as_object().into_iter().flatten();
        paths.extend(topics.map(|(topic, _)| topic.clone()));
    }
    paths
}

/// The elements that a path takes of a field.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Elements {
    /// The field has but one value.
    TheOne,
    At(usize),
    Named(String),
}

/// `/topic.field[1].field` or `/topic.field[:]{name=="x"}.field`, as a topic and its fields.
fn parse(path: &str) -> (Topic, Vec<(String, Elements)>) {
    let (topic, fields) = path.split_once('.').map_or((path, ""), |(topic, fields)| (topic, fields));
    let topic = Topic::from_name(topic).unwrap_or_else(|| panic!("{path}: there is no topic {topic}"));
    let fields = fields.split('.').filter(|field| !field.is_empty()).map(|field| match field.split_once('[') {
        None => (field.to_owned(), Elements::TheOne),
        Some((name, rest)) => {
            let named = rest.strip_prefix(":]{name==\"").and_then(|rest| rest.strip_suffix("\"}"));
            let elements = named.map_or_else(
                || Elements::At(rest.strip_suffix(']').and_then(|index| index.parse().ok()).expect(path)),
                |name| Elements::Named(name.to_owned()),
            );
            (name.to_owned(), elements)
        }
    });
    (topic, fields.collect())
}

/// Messages by their full name, from the schema that logs carry.
fn messages(topic: Topic) -> BTreeMap<String, DescriptorProto> {
    let set = FileDescriptorSet::decode(topic.schema().data.as_slice()).unwrap();
    let messages = set.file.iter().flat_map(|file| {
        file.message_type.iter().map(|message| (format!("{}.{}", file.package(), message.name()), message.clone()))
    });
    messages.collect()
}

/// Follows the fields of a path through the schema to its end.
fn follow(path: &str) {
    let (topic, fields) = parse(path);
    let messages = messages(topic);
    let mut message = topic.schema().name;
    let mut is_number = false;
    for (name, elements) in fields {
        let field = messages[&message].field.iter().find(|field| field.name() == name);
        let field = field.unwrap_or_else(|| panic!("{path}: {message} has no field {name}"));
        let is_list = field.label() == Label::Repeated;
        assert_eq!(is_list, elements != Elements::TheOne, "{path}: {name}");
        if field.r#type() == Type::Message {
            message = field.type_name().trim_start_matches('.').to_owned();
        }
        is_number = !matches!(field.r#type(), Type::Message | Type::Bytes);
    }
    assert!(is_number || !path.contains('.'), "{path} ends at {message}, which cannot be drawn");
}

#[test]
fn every_panel_is_placed_once_and_is_configured() {
    let layout = layout();
    let mut panels = Vec::new();
    placed(&layout["layout"], &mut panels);
    let once: BTreeSet<_> = panels.iter().cloned().collect();
    assert_eq!(once.len(), panels.len(), "{panels:?}");
    let configured: BTreeSet<_> = layout["configById"].as_object().unwrap().keys().cloned().collect();
    assert_eq!(once, configured);
    for kind in ["3D", "Plot", "StateTransitions", "RosOut"] {
        assert!(panels.iter().any(|panel| panel.starts_with(&format!("{kind}!"))), "no {kind} panel");
    }
}

#[test]
fn every_message_path_is_in_the_schemas() {
    let paths = paths(&layout());
    assert!(paths.len() > 20, "{paths:?}");
    paths.iter().for_each(|path| follow(path));
}

/// How many values a list has in a recorded run.
fn lengths(log: &[u8]) -> BTreeMap<String, usize> {
    let mut lengths = BTreeMap::new();
    for message in MessageStream::new(log).unwrap().map(Result::unwrap) {
        match Topic::from_name(&message.channel.topic) {
            Some(Topic::Control) => {
                let control = uarm_log::proto::ControlSample::decode(&*message.data).unwrap();
                for (name, length) in [
                    ("reference_position", control.reference_position.len()),
                    ("tracking_error", control.tracking_error.len()),
                    ("torque_applied", control.torque_applied.len()),
                    ("torque_requested", control.torque_requested.len()),
                    ("disturbance", control.disturbance.len()),
                    ("limited", control.limited.len()),
                ] {
                    lengths.insert(format!("/control.{name}"), length);
                }
            }
            Some(Topic::Drives) => {
                let drives = uarm_log::proto::DriveStates::decode(&*message.data).unwrap();
                lengths.insert("/drives.drives".to_owned(), drives.drives.len());
            }
            _ => {}
        }
    }
    lengths
}

fn record() -> PathBuf {
    let file = std::env::temp_dir().join(format!("uarm-layout-{}.mcap", std::process::id()));
    let mut run = Command::new(env!("CARGO_BIN_EXE_uarm"));
    let output = run.args(["run", "--virtual-time", "--hold", "0s", "--log"]).arg(&file).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    file
}

#[test]
fn every_element_is_there_in_a_recorded_run() {
    let file = record();
    let lengths = lengths(&std::fs::read(&file).unwrap());
    std::fs::remove_file(file).unwrap();
    let joints = Robot::load(None).unwrap().description.joints.map(|joint| joint.name);
    for path in paths(&layout()) {
        let (topic, fields) = parse(&path);
        for (name, elements) in fields {
            match elements {
                Elements::TheOne => {}
                Elements::At(index) => assert!(index < lengths[&format!("{}.{name}", topic.name())], "{path}"),
                Elements::Named(wanted) => assert!(joints.contains(&wanted), "{path}: joints are {joints:?}"),
            }
        }
    }
}

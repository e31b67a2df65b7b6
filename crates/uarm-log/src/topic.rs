//! The topics of a run log and their schemas.

use foxglove::Encode;
use foxglove::messages::{FrameTransforms, JointStates, Log, SceneUpdate};

/// All topics are protobuf, and so are their schemas: a `FileDescriptorSet`.
pub const ENCODING: &str = "protobuf";

/// What the library in the header of a run log begins with.
pub const LIBRARY: &str = "uarm ";

/// A topic of a run log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// Angles, velocities and torques, for Foxglove.
    JointStates,
    /// Where the links are, for Foxglove's 3-D scene.
    Transforms,
    /// What they look like.
    Scene,
    /// The signals of each cycle.
    Control,
    /// The instants of each cycle.
    Timing,
    /// What each drive said and was told in each cycle.
    Drives,
    /// Every frame that the controller sent or received.
    CanFrames,
    /// Counters and ages of bus and drives.
    CanHealth,
    /// The frozen inner state.
    Keyframes,
    /// Lines of text with a severity.
    Log,
    /// Why the run failed.
    Fault,
}

macro_rules! own {
    ($message:literal, $file:literal) => {
        Schema {
            name: concat!("uarm.", $message).to_owned(),
            data: include_bytes!(concat!(env!("OUT_DIR"), "/", $file, ".fds")).to_vec(),
        }
    };
}

/// A schema as the file holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema {
    /// The message's full name.
    pub name: String,
    /// The descriptor set of the message and of what it refers to.
    pub data: Vec<u8>,
}

fn of_foxglove<M: Encode>() -> Schema {
    // Each of Foxglove's messages has a schema; were it not so, readers would miss it and a test does.
    M::get_schema().map_or_else(
        || Schema { name: String::new(), data: Vec::new() },
        |schema| Schema { name: schema.name, data: schema.data.into_owned() },
    )
}

impl Topic {
    /// All topics, in the order of their channels.
    pub const ALL: [Self; 11] = [
        Self::JointStates,
        Self::Transforms,
        Self::Scene,
        Self::Control,
        Self::Timing,
        Self::Drives,
        Self::CanFrames,
        Self::CanHealth,
        Self::Keyframes,
        Self::Log,
        Self::Fault,
    ];

    /// The name of the topic in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::JointStates => "/joint_states",
            Self::Transforms => "/tf",
            Self::Scene => "/scene",
            Self::Control => "/control",
            Self::Timing => "/timing",
            Self::Drives => "/drives",
            Self::CanFrames => "/can/frames",
            Self::CanHealth => "/can/health",
            Self::Keyframes => "/keyframes",
            Self::Log => "/log",
            Self::Fault => "/fault",
        }
    }

    /// The channel that a run log has it on.
    pub fn channel(self) -> u16 {
        let position = Self::ALL.iter().zip(1..).find(|(each, _)| **each == self);
        position.map_or(0, |(_, number)| number)
    }

    /// The topic of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// The schema of its messages.
    pub fn schema(self) -> Schema {
        match self {
            Self::JointStates => of_foxglove::<JointStates>(),
            Self::Transforms => of_foxglove::<FrameTransforms>(),
            Self::Scene => of_foxglove::<SceneUpdate>(),
            Self::Log => of_foxglove::<Log>(),
            Self::Control => own!("ControlSample", "control"),
            Self::Timing => own!("LoopTiming", "timing"),
            Self::Drives => own!("DriveStates", "drives"),
            Self::CanFrames => own!("CanFrame", "can"),
            Self::CanHealth => own!("CanHealth", "can"),
            Self::Keyframes => own!("Keyframe", "keyframe"),
            Self::Fault => own!("Fault", "fault"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_topic_has_a_schema_whose_descriptor_names_its_message() {
        for topic in Topic::ALL {
            let Schema { name, data } = topic.schema();
            let message = name.rsplit('.').next().unwrap();
            assert!(data.windows(message.len()).any(|bytes| bytes == message.as_bytes()), "{topic:?}: {name}");
            assert_eq!(Topic::from_name(topic.name()), Some(topic));
        }
    }
}

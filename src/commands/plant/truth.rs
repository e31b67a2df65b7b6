//! The plant's truth as an MCAP or CSV file: one message or line for each SYNC while plant time passes.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Context;
use serde::Serialize;
use uarm_log::json_topic::{JsonTopic, JsonTopicWriter};
use uarm_sim::Brake;

use super::bench::Truth;
use crate::output_files::OutputFiles;

/// The file.
#[derive(Debug)]
pub struct TruthFile {
    path: PathBuf,
    format: Format,
    run: u32,
    last: Option<Duration>,
}

impl TruthFile {
    /// Begins a file of a robot of so many `joints`.
    ///
    /// # Errors
    /// If it cannot be written, or may not be replaced.
    pub fn create(path: &Path, joints: usize, outputs: &OutputFiles) -> anyhow::Result<Self> {
        let file = outputs.create(path)?;
        let is_mcap = path.extension().is_some_and(|extension| extension == "mcap");
        let format = if is_mcap { Format::mcap(file) } else { Format::csv(file, joints) };
        let format = format.with_context(|| path.display().to_string())?;
        Ok(Self { path: path.to_owned(), format, run: 0, last: None })
    }

    /// Writes a line, if plant time passes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&mut self, truth: Option<&Truth>) -> anyhow::Result<()> {
        let Some(truth) = truth else {
            self.last = None;
            return self.flush();
        };
        if self.last.is_none_or(|last| truth.time < last) {
            self.run += 1;
        }
        self.last = Some(truth.time);
        self.format.write(self.run, truth).with_context(|| self.path.display().to_string())
    }

    /// Writes what is still to be written.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> anyhow::Result<()> {
        let Self { path, format, .. } = self;
        format.finish().with_context(|| path.display().to_string())
    }

    fn flush(&mut self) -> anyhow::Result<()> {
        self.format.flush().with_context(|| self.path.display().to_string())
    }
}

/// How the truth is written.
enum Format {
    Csv(BufWriter<File>),
    Mcap(Box<JsonTopicWriter<File>>),
}

impl std::fmt::Debug for Format {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Csv(_) => "Csv",
            Self::Mcap(_) => "Mcap",
        })
    }
}

/// The topic of an MCAP file.
const TOPIC: JsonTopic =
    JsonTopic { name: "/truth", schema_name: "uarm.Truth", schema: include_str!("truth.schema.json") };

/// A message: the joints from the base outwards.
#[derive(Serialize)]
struct Message {
    run: u32,
    time_s: f64,
    position_rad: Vec<f64>,
    velocity_rad_per_s: Vec<f64>,
    torque_nm: Vec<f64>,
    brake: Vec<bool>,
}

impl Message {
    fn new(run: u32, truth: &Truth) -> Self {
        let joints = &truth.joints;
        Self {
            run,
            time_s: truth.time.as_secs_f64(),
            position_rad: joints.iter().map(|joint| joint.position).collect(),
            velocity_rad_per_s: joints.iter().map(|joint| joint.velocity).collect(),
            torque_nm: joints.iter().map(|joint| joint.torque).collect(),
            brake: joints.iter().map(|joint| joint.brake == Brake::Engaged).collect(),
        }
    }
}

impl Format {
    fn csv(file: File, joints: usize) -> anyhow::Result<Self> {
        let mut file = BufWriter::new(file);
        writeln!(file, "{}", header(joints))?;
        Ok(Self::Csv(file))
    }

    fn mcap(file: File) -> anyhow::Result<Self> {
        Ok(Self::Mcap(Box::new(JsonTopicWriter::new(file, &TOPIC)?)))
    }

    fn write(&mut self, run: u32, truth: &Truth) -> anyhow::Result<()> {
        match self {
            Self::Csv(file) => writeln!(file, "{}", line_of(run, truth))?,
            Self::Mcap(writer) => {
                // The wall clock, as in the controller's own log: both lie over each other in one view.
                let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
                let now = u64::try_from(now.as_nanos()).unwrap_or(u64::MAX);
                writer.write(now, &serde_json::to_vec(&Message::new(run, truth))?)?;
            }
        }
        Ok(())
    }

    fn flush(&mut self) -> anyhow::Result<()> {
        match self {
            Self::Csv(file) => file.flush()?,
            Self::Mcap(writer) => writer.flush()?,
        }
        Ok(())
    }

    fn finish(self) -> anyhow::Result<()> {
        match self {
            Self::Csv(mut file) => file.flush()?,
            Self::Mcap(writer) => writer.finish()?,
        }
        Ok(())
    }
}

/// The columns. `run` counts the runs of the plant from 1: each NMT reset of all drives ends one. `brake` is 1 while it holds.
fn header(joints: usize) -> String {
    let columns = [("position", "_rad"), ("velocity", "_rad_per_s"), ("torque", "_nm"), ("brake", "")];
    let columns =
        columns.iter().flat_map(|(name, unit)| (1..=joints).map(move |joint| format!(",{name}_{joint}{unit}")));
    format!("run,time_s{}", columns.collect::<String>())
}

/// Numbers are written so that they read back as the same bits.
fn line_of(run: u32, truth: &Truth) -> String {
    let Message { time_s, position_rad, velocity_rad_per_s, torque_nm, brake, .. } = Message::new(run, truth);
    let numbers = [position_rad, velocity_rad_per_s, torque_nm].concat();
    let brakes = brake.into_iter().map(u8::from);
    let cells = numbers.iter().map(ToString::to_string).chain(brakes.map(|brake| brake.to_string()));
    format!("{run},{time_s},{}", cells.collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::plant::bench::JointTruth;

    fn truth() -> Truth {
        let joint = |position, velocity, torque, brake| JointTruth { position, velocity, torque, brake };
        let joints = vec![
            joint(0.0, -1.0, 0.0, Brake::Engaged),
            joint(0.1, 0.5, 0.025, Brake::Released),
            joint(0.2, 1e-9, -0.0125, Brake::Released),
        ];
        Truth { time: Duration::from_millis(3), joints }
    }

    #[test]
    fn a_message_has_the_truth_under_the_names_of_its_schema() {
        let path = std::env::temp_dir().join(format!("uarm-truth-{}.mcap", std::process::id()));
        let mut format = Format::mcap(File::create(&path).unwrap()).unwrap();
        format.write(2, &truth()).unwrap();
        format.finish().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
        let [message] = messages.as_slice() else { panic!("{} messages", messages.len()) };
        assert_eq!((message.channel.topic.as_str(), message.channel.message_encoding.as_str()), ("/truth", "json"));
        let found: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        let expected = serde_json::json!({
            "run": 2, "time_s": 0.003, "position_rad": [0.0, 0.1, 0.2], "velocity_rad_per_s": [-1.0, 0.5, 1e-9],
            "torque_nm": [0.0, 0.025, -0.0125], "brake": [true, false, false],
        });
        assert_eq!(found, expected);
        let schema: serde_json::Value = serde_json::from_slice(&message.channel.schema.as_ref().unwrap().data).unwrap();
        let named: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
        assert_eq!(named, expected.as_object().unwrap().keys().collect::<Vec<_>>());
    }

    #[test]
    fn a_line_has_the_columns_of_the_header() {
        assert_eq!(line_of(2, &truth()), "2,0.003,0,0.1,0.2,-1,0.5,0.000000001,0,0.025,-0.0125,1,0,0");
        let three = "run,time_s,position_1_rad,position_2_rad,position_3_rad,velocity_1_rad_per_s,velocity_2_rad_per_s,\
            velocity_3_rad_per_s,torque_1_nm,torque_2_nm,torque_3_nm,brake_1,brake_2,brake_3";
        assert_eq!(header(3), three);
        let last = ["position_7_rad", "velocity_7_rad_per_s", "torque_7_nm", "brake_7"];
        let seven = header(7);
        let columns: Vec<&str> = seven.split(',').collect();
        assert_eq!([8, 15, 22, 29].map(|column| columns[column]), last);
    }
}

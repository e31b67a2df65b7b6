//! Dictionaries with the traits of makers, written by hand. What the answers share is here; the questions are in files by subject.

mod bus;
mod device;
mod pdos;
mod readings;
mod scales;

use super::*;
use crate::drive::network::NetworkConfiguration;
use crate::drive::objects::{self, Object};
use crate::drive::pdo_objects::{PdoKind, PdoNumber};
use crate::drive::survey::{Access, Answered, ObjectSource, SourceKind};
use crate::drive::wishes::{
    AbortOption, Heartbeats, Homing, Operation, PinnedIdentity, Resolution, Setting, SyncCounterChoice, SyncPayload,
    TorqueReference, Watchdog, WatchdogTest,
};
use crate::torque::{RatedTorque, TorqueUnit};
use canopen_rs::{Address, NodeId, Value};
use core::convert::Infallible;
use core::time::Duration;
use std::collections::BTreeMap;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

/// A dictionary as a file states it.
#[derive(Clone, Default)]
struct Dictionary(BTreeMap<(u16, u8), Answered>);

impl ObjectSource for Dictionary {
    type Error = Infallible;

    fn ask(&mut self, object: &Object) -> Result<Answered, Infallible> {
        Ok(self.0.get(&(object.index, object.subindex)).copied().unwrap_or_default())
    }
}

/// The same, where it says that it is a file.
struct File(Dictionary);

impl ObjectSource for File {
    type Error = Infallible;

    fn ask(&mut self, object: &Object) -> Result<Answered, Infallible> {
        self.0.ask(object)
    }

    fn kind(&self) -> SourceKind {
        SourceKind::DictionaryFile
    }
}

impl Dictionary {
    fn with(mut self, index: u16, subindex: u8, answer: Answer, access: Access) -> Self {
        self.0.insert((index, subindex), Answered { answer, access, ..Answered::default() });
        self
    }

    fn rw(self, index: u16, subindex: u8, value: i64) -> Self {
        self.with(index, subindex, Answer::Number(value), Access::ReadWrite)
    }

    fn ro(self, index: u16, subindex: u8, value: i64) -> Self {
        self.with(index, subindex, Answer::Number(value), Access::ReadOnly)
    }

    fn unstated(self, index: u16, subindex: u8, access: Access) -> Self {
        self.with(index, subindex, Answer::Unstated, access)
    }

    fn without(mut self, index: u16, subindex: u8) -> Self {
        self.0.remove(&(index, subindex));
        self
    }

    fn limited(mut self, index: u16, subindex: u8, least: i64, most: i64) -> Self {
        let object = self.0.get_mut(&(index, subindex)).unwrap();
        (object.least, object.most) = (Some(least), Some(most));
        self
    }

    fn pdo(self, parameter: u16, identifier: i64, transmission: i64, mapping: &[i64]) -> Self {
        let mut dictionary = self.rw(parameter, 1, identifier).rw(parameter, 2, transmission);
        dictionary = dictionary.rw(parameter + 0x200, 0, mapping.len() as i64);
        for (subindex, entry) in (1..).zip(mapping) {
            dictionary = dictionary.rw(parameter + 0x200, subindex, *entry);
        }
        dictionary
    }
}

const NODE: u8 = 2;
const COUNTS: u32 = 33_739;

/// A drive of which everything is as the master wants it, but for what every start writes.
fn drive() -> Dictionary {
    Dictionary::default()
        .ro(0x1000, 0, 0x0002_0192)
        .ro(0x1018, 1, 0x55)
        .rw(0x1005, 0, 0x80)
        .ro(0x1014, 0, 0x82)
        .rw(0x1016, 1, 0)
        .rw(0x1017, 0, 0)
        .rw(0x1019, 0, 0)
        .rw(0x6007, 0, 1)
        .rw(0x6040, 0, 0)
        .ro(0x6041, 0, 0)
        .rw(0x605A, 0, 2)
        .rw(0x6060, 0, 0)
        .ro(0x6061, 0, 0)
        .ro(0x6064, 0, 0)
        .rw(0x6071, 0, 0)
        .rw(0x6072, 0, 1000)
        .rw(0x6075, 0, 3000)
        .rw(0x6076, 0, 200)
        .ro(0x6077, 0, 0)
        .ro(0x608F, 1, COUNTS.into())
        .ro(0x608F, 2, 1)
        .rw(0x60C2, 1, 1)
        .rw(0x60C2, 2, -3)
        .ro(0x6502, 0, 1 << 9)
        .pdo(0x1400, 0x202, 255, &[0x6040_0010])
        .pdo(0x1800, 0x182, 255, &[0x6041_0010])
}

fn wishes() -> DriveConfiguration {
    DriveConfiguration::new(NodeId::new(NODE).unwrap(), COUNTS, RatedTorque::from_millinewton_metres(200).unwrap())
}

fn protocol() -> Protocol {
    Protocol { period: Duration::from_millis(3), heartbeats: Heartbeats::default(), sync_payload: SyncPayload::Counter }
}

fn survey(mut dictionary: Dictionary, drive: &DriveConfiguration) -> Survey {
    let Ok(survey) = survey_of(&mut dictionary, drive);
    survey
}

fn planned(dictionary: Dictionary, drive: &DriveConfiguration) -> Plan {
    plan(&survey(dictionary, drive), drive, &protocol())
}

fn planned_from_file(dictionary: Dictionary, drive: &DriveConfiguration) -> Plan {
    let Ok(survey) = survey_of(&mut File(dictionary), drive);
    plan(&survey, drive, &protocol())
}

fn finding(plan: &Plan, question: Question) -> Finding {
    *plan.findings.iter().find(|finding| finding.question == question).unwrap()
}

/// What is written, as `index:subindex = number`.
fn written(plan: &Plan) -> Vec<String> {
    let shown = |setting: &Setting| {
        let Address { index, subindex } = setting.address;
        format!("{index:04X}:{subindex} = {:X}", Answer::of(setting.value).number().unwrap())
    };
    plan.settings.iter().map(shown).collect()
}

fn of_index<'a>(written: &'a [String], indices: &[&str]) -> Vec<&'a str> {
    written.iter().map(String::as_str).filter(|text| indices.iter().any(|index| text.starts_with(index))).collect()
}

#[test]
fn a_good_drive_is_configured_in_the_standards_order() {
    let plan = planned(drive(), &wishes());
    assert_eq!(plan.verdict(), Verdict::Works, "{:#?}", plan.notes().collect::<Vec<_>>());
    let expected = [
        "6060:0 = A",
        "1400:1 = 80000202",
        "1600:0 = 0",
        "1600:2 = 60710010",
        "1600:0 = 2",
        "1400:1 = 202",
        "1800:1 = 80000182",
        "1A00:0 = 0",
        "1A00:2 = 60640020",
        "1A00:0 = 2",
        "1800:2 = 1",
        "1800:1 = 182",
        "1019:0 = F0",
        "60C2:1 = 3",
        "1017:0 = 32",
        "1016:1 = 7F0064",
    ];
    assert_eq!(written(&plan), expected);
}

#[test]
fn every_question_is_answered_in_its_order() {
    let plan = planned(drive(), &wishes());
    let questions: Vec<Question> = plan.findings.iter().map(|finding| finding.question).collect();
    assert_eq!(questions, Question::ALL);
}

/// What a start has written is not written again.
#[test]
fn what_is_right_already_is_not_written() {
    let mut dictionary = drive();
    for setting in &planned(drive(), &wishes()).settings {
        let Address { index, subindex } = setting.address;
        dictionary = dictionary.rw(index, subindex, Answer::of(setting.value).number().unwrap());
    }
    assert_eq!(written(&planned(dictionary, &wishes())), Vec::<String>::new());
}

#[test]
fn an_entry_of_the_robot_file_reads_well() {
    let setting = Setting::of(&objects::ABORT_CONNECTION_OPTION, Value::Integer16(1));
    assert_eq!(
        Remedy::Write(setting).to_string(),
        "drive.writes: { index = 0x6007, subindex = 0, type = \"i16\", value = 1 }"
    );
}

//! The findings in words, in JSON, and as an entry of the robot file.

use std::fmt::{self, Write};

use serde::Serialize;
use toml::{Table, Value};
use uarm_io::drive::plan::{Remedy, Verdict};
use uarm_io::drive::words::Named;

use super::candidate::Candidate;
use super::judgement::{Judgement, Outcome, Row};

/// What is printed of a judgement.
#[derive(Debug, Serialize)]
pub struct Report {
    drive: String,
    node: u8,
    verdict: &'static str,
    rows: Vec<ReportRow>,
    /// The joint's drive profile, and from what it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    profile: Option<String>,
    /// What is to be changed beside that entry, for all drives alike.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    shared: Vec<String>,
    /// The entry of `[[joints]]`; none for a drive that cannot work.
    joint: Option<String>,
}

#[derive(Debug, Serialize)]
struct ReportRow {
    question: &'static str,
    objects: &'static str,
    verdict: &'static str,
    object: String,
    found: String,
    wanted: String,
    remedies: Vec<String>,
}

impl Report {
    /// Of a drive, called `drive`.
    ///
    /// # Errors
    /// If the candidate has become one that is refused.
    pub fn new(drive: String, judgement: &Judgement, candidate: &Candidate) -> anyhow::Result<Self> {
        let verdict = match judgement.outcome {
            Outcome::Works => "works",
            Outcome::WorksWith => "works with the entry below",
            Outcome::Cannot => "cannot be used",
        };
        let is_usable = judgement.outcome != Outcome::Cannot;
        Ok(Self {
            drive,
            node: candidate.node()?.raw(),
            verdict,
            profile: candidate.profile()?,
            rows: judgement.rows.iter().map(ReportRow::new).collect(),
            shared: candidate.shared().iter().filter(|_| is_usable).cloned().collect(),
            joint: candidate.joint().filter(|_| is_usable).map(joint_text),
        })
    }
}

impl ReportRow {
    fn new(row: &Row) -> Self {
        let finding = &row.finding;
        let verdict = match (finding.verdict, finding.remedy) {
            _ if !row.remedies.is_empty() => "set",
            (Verdict::Cannot, _) => "no",
            (_, Remedy::Note(_)) => "note",
            _ => "ok",
        };
        let mut remedies = row.remedies.clone();
        if remedies.is_empty() && finding.remedy != Remedy::None {
            remedies.push(finding.remedy.to_string());
        }
        Self {
            question: finding.question.title(),
            objects: finding.question.objects(),
            verdict,
            object: Named(finding.object).to_string(),
            found: finding.found.to_string(),
            wanted: finding.wanted.to_string(),
            remedies,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}, as node {}\n", self.drive, self.node)?;
        if let Some(profile) = &self.profile {
            writeln!(f, "{profile}\n")?;
        }
        for row in &self.rows {
            writeln!(f, "{:4}  {} ({})", row.verdict, row.question, row.objects)?;
            writeln!(f, "      {}: found {}; wanted {}", row.object, row.found, row.wanted)?;
            for remedy in &row.remedies {
                writeln!(f, "      → {remedy}")?;
            }
        }
        for shared in &self.shared {
            write!(f, "\n{shared}")?;
        }
        if let Some(joint) = &self.joint {
            writeln!(f, "\n{joint}")?;
        }
        writeln!(f, "{}: {}", self.drive, self.verdict)
    }
}

/// The order of a joint's keys in robot files; others follow.
const KEYS: [&str; 6] = ["name", "role", "node", "encoder", "drive", "limits"];
/// The order of the keys of an entry of `writes`.
const WRITE_KEYS: [&str; 4] = ["index", "subindex", "type", "value"];

/// A joint as robot files have it.
fn joint_text(joint: &Table) -> String {
    let mut text = "[[joints]]\n".to_owned();
    for (key, value) in ordered(joint, &KEYS) {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{key} = {}", inline(key, value));
    }
    text
}

fn ordered<'a>(table: &'a Table, first: &'a [&str]) -> impl Iterator<Item = (&'a str, &'a Value)> {
    let listed = first.iter().filter_map(|key| table.get_key_value(*key));
    let others = table.iter().filter(|(key, _)| !first.contains(&key.as_str()));
    listed.chain(others).map(|(key, value)| (key.as_str(), value))
}

/// A value on one line, indices of objects in hexadecimal.
fn inline(key: &str, value: &Value) -> String {
    match value {
        Value::Integer(index) if key == "index" => format!("0x{index:04X}"),
        Value::Table(table) => {
            let pairs = ordered(table, &WRITE_KEYS).map(|(key, value)| format!("{key} = {}", inline(key, value)));
            format!("{{ {} }}", pairs.collect::<Vec<_>>().join(", "))
        }
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(|value| inline("", value)).collect();
            format!("[{}]", values.join(", "))
        }
        _ => value.to_string(),
    }
}

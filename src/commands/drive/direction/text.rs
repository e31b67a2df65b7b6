//! What was found out about a joint that was turned.

use std::fmt::Write;

use serde::Serialize;
use uarm_io::encoder::{Direction, EncoderConfiguration};

use super::turning::{Turning, Wrap};

/// How far the counts of a turn by hand may be from the robot file's, as a share: nobody stops at a mark exactly.
const TURN_TOLERANCE: f64 = 0.05;

/// What the counts of a joint that was turned tell.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    node: u8,
    readings: u32,
    first_counts: Option<i32>,
    last_counts: i32,
    /// Counts from the first to the last reading, wraps taken out.
    travelled_counts: i64,
    /// The furthest either way.
    extreme_counts: [i64; 2],
    turns: f64,
    /// Absent if the joint was not turned.
    direction: Option<Direction>,
    counts_per_revolution_seen: Option<f64>,
    wrap: Option<Wrap>,
    /// What the robot file says otherwise.
    disagreements: Vec<String>,
}

impl Finding {
    /// What `turning` tells of a joint that was turned by `turns` revolutions counter-clockwise; compared with `encoder`.
    pub fn new(node: u8, turning: &Turning, turns: f64, encoder: Option<EncoderConfiguration>) -> Self {
        let direction = turning.direction();
        let mut finding = Self {
            node,
            readings: turning.readings(),
            first_counts: turning.first(),
            last_counts: turning.last(),
            travelled_counts: turning.travelled(),
            extreme_counts: turning.extremes(),
            turns,
            direction,
            counts_per_revolution_seen: direction.map(|_| turning.travelled().abs() as f64 / turns),
            wrap: turning.wrap(),
            disagreements: Vec::new(),
        };
        if let Some(encoder) = encoder {
            finding.compare(&encoder);
        }
        finding
    }

    fn compare(&mut self, encoder: &EncoderConfiguration) {
        if let Some(found) = self.direction.filter(|found| *found != encoder.direction) {
            let [found, said] = [found, encoder.direction].map(word);
            self.disagreements.push(format!("direction is \"{found}\", the robot file says \"{said}\""));
        }
        let expected = encoder.counts_per_revolution.per_revolution();
        if let Some(seen) = self.counts_per_revolution_seen
            && (seen - expected).abs() > TURN_TOLERANCE * expected
        {
            self.disagreements.push(format!("{seen:.0} counts per revolution, the robot file says {expected:.0}"));
        }
        let width = encoder.counter_width.get();
        if let Some(bits) = self.wrap.and_then(|wrap| wrap.counter_bits).filter(|bits| *bits != width) {
            self.disagreements.push(format!("its counter has {bits} bits, the robot file says {width}"));
        }
    }

    /// True if the joint was turned, and nothing disagrees.
    pub fn is_good(&self) -> bool {
        self.direction.is_some() && self.disagreements.is_empty()
    }

    /// As a person reads it.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let [least, most] = self.extreme_counts;
        let first = self.first_counts.map_or_else(|| "-".to_owned(), |counts| counts.to_string());
        let _ = writeln!(
            text,
            "node {}: {} readings of 6064h, from {first} to {}",
            self.node, self.readings, self.last_counts
        );
        let _ = writeln!(text, "  travelled {:+} counts, at most {least:+} and {most:+}", self.travelled_counts);
        match (self.direction, self.counts_per_revolution_seen) {
            (Some(direction), Some(counts)) => {
                let _ = writeln!(
                    text,
                    "  counter-clockwise counts {}: direction = \"{}\"",
                    up_or_down(direction),
                    word(direction)
                );
                let _ =
                    writeln!(text, "  {counts:.0} counts per revolution, if the joint was turned by {}", self.turns);
            }
            _ => text.push_str("  the joint was not turned: is its brake closed?\n"),
        }
        match self.wrap {
            Some(Wrap { from, to, counter_bits: Some(bits) }) => {
                let _ = writeln!(text, "  the counter wraps from {from} to {to}: counter_bits = {bits}");
            }
            Some(Wrap { from, to, counter_bits: None }) => {
                let _ = writeln!(text, "  the counter went from {from} to {to} at once");
            }
            None => text.push_str("  no wrap was seen\n"),
        }
        for disagreement in &self.disagreements {
            let _ = writeln!(text, "  DISAGREES: {disagreement}");
        }
        text
    }
}

const fn word(direction: Direction) -> &'static str {
    match direction {
        Direction::Positive => "positive",
        Direction::Negative => "negative",
    }
}

const fn up_or_down(direction: Direction) -> &'static str {
    match direction {
        Direction::Positive => "up",
        Direction::Negative => "down",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;

    fn turned(readings: &[i32]) -> Finding {
        let mut turning = Turning::default();
        readings.iter().for_each(|reading| turning.note(*reading));
        // 33 739 counts per revolution, positive, 32 bits.
        let encoder = Robot::load(None).unwrap().description.joints[1].encoder;
        Finding::new(2, &turning, 1.0, Some(encoder))
    }

    #[test]
    fn a_revolution_that_counts_as_the_file_says_is_good() {
        let finding = turned(&[0, 15_000, 33_000]);
        assert!(finding.is_good(), "{finding:?}");
        assert!(finding.text().contains("counts up: direction = \"positive\""), "{}", finding.text());
        assert!(finding.text().contains("33000 counts per revolution"), "{}", finding.text());
    }

    #[test]
    fn what_the_file_says_otherwise_is_told() {
        let finding = turned(&[0, -15_000, -25_000]);
        assert!(!finding.is_good());
        let text = finding.text();
        assert!(text.contains("DISAGREES: direction is \"negative\", the robot file says \"positive\""), "{text}");
        assert!(text.contains("DISAGREES: 25000 counts per revolution, the robot file says 33739"), "{text}");
        let text = turned(&[32_760, -32_760, -31_000]).text();
        assert!(text.contains("its counter has 16 bits, the robot file says 32"), "{text}");
    }

    #[test]
    fn a_joint_that_was_not_turned_is_no_success() {
        let finding = turned(&[5, 6, 5]);
        assert!(!finding.is_good() && finding.text().contains("not turned"), "{}", finding.text());
        assert_eq!(serde_json::to_value(&finding).unwrap()["direction"], serde_json::Value::Null);
    }
}

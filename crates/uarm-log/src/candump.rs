//! `candump -L` files, as the can-utils write and read them: one frame a line.
//!
//! ```text
//! (1436509052.249713) can0 181#2106E8030000
//! ```
//!
//! Written with nine digits of the second, since the instants are known to the nanosecond; can-utils of 2023 and later read
//! both. Read with any number of digits. What a drive's protocol does not use (remote frames, 29-bit identifiers, CAN FD,
//! error frames) is left out and counted.

use std::io::{self, BufRead, Write};

use embedded_can::StandardId;
use uarm_loop::uarm_io::drive::wire::{Channel, MASTER_NODE};
use uarm_loop::uarm_io::frame::Frame;
use uarm_loop::uarm_io::link::FrameDirection;
use uarm_loop::uarm_io::time::Instant;

use crate::time_axis::TimeAxis;
use uarm_loop::recording::FrameRecord;

const NANOSECONDS_PER_SECOND: u64 = 1_000_000_000;
/// Digits of a nanosecond.
const NANOSECOND_DIGITS: usize = 9;

/// Frames that were read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Candump {
    /// In the order of the file; instants are times of day, or since boot, as the file has them.
    pub frames: Vec<FrameRecord>,
    /// Lines with frames that the drives' protocol does not use.
    pub left_out: usize,
}

/// Why a file cannot be read as one that candump wrote.
#[derive(Debug, thiserror::Error)]
pub enum CandumpError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A line is not one of candump's.
    #[error("line {number}: `{text}`, expected a line of candump -L such as `(1436509052.249713) can0 181#2106E803`")]
    Line {
        /// The number of the line, counted from 1.
        number: usize,
        /// The text of the line.
        text: String,
    },
}

/// What a line holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Line {
    Frame(Instant, Frame),
    LeftOut,
}

/// Reads a file.
///
/// # Errors
/// [`CandumpError`] names the line.
pub fn read(input: impl BufRead) -> Result<Candump, CandumpError> {
    let mut candump = Candump::default();
    for (index, text) in input.lines().enumerate() {
        let text = text?;
        if text.trim().is_empty() {
            continue;
        }
        match line(&text) {
            Some(Line::Frame(at, frame)) => {
                let sequence = u32::try_from(candump.frames.len()).unwrap_or(u32::MAX);
                candump.frames.push(FrameRecord { sequence, direction: direction(&frame), frame, at });
            }
            Some(Line::LeftOut) => candump.left_out += 1,
            None => return Err(CandumpError::Line { number: index + 1, text }),
        }
    }
    Ok(candump)
}

fn line(text: &str) -> Option<Line> {
    let mut words = text.split_whitespace();
    let at = time(words.next()?.strip_prefix('(')?.strip_suffix(')')?)?;
    let _interface = words.next()?;
    let (identifier, payload) = words.next()?.split_once('#')?;
    // Newer can-utils tell the direction by a last word.
    if !matches!(words.next(), None | Some("R" | "T")) || words.next().is_some() {
        return None;
    }
    /// Hexadecimal digits of an 11-bit identifier; longer ones are 29-bit identifiers and error frames.
    const STANDARD_DIGITS: usize = 3;
    let raw = u32::from_str_radix(identifier, 16).ok()?;
    if identifier.len() != STANDARD_DIGITS || payload.starts_with(['#', 'R']) {
        return Some(Line::LeftOut);
    }
    let id = StandardId::new(u16::try_from(raw).ok()?)?;
    Some(Line::Frame(at, Frame::new(id, &bytes(payload)?)?))
}

fn time(text: &str) -> Option<Instant> {
    let (seconds, fraction) = text.split_once('.')?;
    if fraction.is_empty() || fraction.len() > NANOSECOND_DIGITS || !fraction.bytes().all(|byte| byte.is_ascii_digit())
    {
        return None;
    }
    let nanoseconds: u64 = format!("{fraction:0<NANOSECOND_DIGITS$}").parse().ok()?;
    let seconds: u64 = seconds.parse().ok()?;
    Some(Instant::from_nanoseconds(seconds.checked_mul(NANOSECONDS_PER_SECOND)?.checked_add(nanoseconds)?))
}

/// Pairs of hexadecimal digits; candump puts no dots between them, other tools do.
fn bytes(text: &str) -> Option<Vec<u8>> {
    let digits: Vec<char> = text.chars().filter(|digit| *digit != '.').collect();
    let pairs = digits.chunks(2).map(|pair| match pair {
        [high, low] => u8::try_from(high.to_digit(16)? * 16 + low.to_digit(16)?).ok(),
        _ => None,
    });
    pairs.collect()
}

/// A file does not tell who sent a frame; its channel does.
fn direction(frame: &Frame) -> FrameDirection {
    match Channel::of(frame.id()) {
        Some(Channel::Heartbeat(node)) if node.raw() == MASTER_NODE => FrameDirection::Sent,
        Some(Channel::Emergency(_) | Channel::Tpdo1(_) | Channel::SdoResponse(_) | Channel::Heartbeat(_)) => {
            FrameDirection::Received
        }
        _ => FrameDirection::Sent,
    }
}

/// Writes frames as they would have been seen on `interface`.
///
/// # Errors
/// If the output cannot be written.
pub fn write(frames: &[FrameRecord], interface: &str, axis: TimeAxis, mut output: impl Write) -> io::Result<()> {
    for record in frames {
        let at = axis.at(record.at);
        let (seconds, nanoseconds) = (at / NANOSECONDS_PER_SECOND, at % NANOSECONDS_PER_SECOND);
        write!(output, "({seconds:010}.{nanoseconds:09}) {interface} {:03X}#", record.frame.id().as_raw())?;
        for byte in record.frame.data() {
            write!(output, "{byte:02X}")?;
        }
        writeln!(output)?;
    }
    output.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    prop_compose! {
        fn any_frame()(
            id in 0..0x800_u16,
            data in prop::collection::vec(any::<u8>(), 0..=8),
            at in 0..1_u64 << 62,
        ) -> (Frame, Instant) {
            (Frame::new(StandardId::new(id).unwrap(), &data).unwrap(), Instant::from_nanoseconds(at))
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(frames in prop::collection::vec(any_frame(), 0..20)) {
            let records: Vec<_> = frames.iter().zip(0..).map(|((frame, at), sequence)| {
                FrameRecord { sequence, direction: direction(frame), frame: *frame, at: *at }
            }).collect();
            let mut text = Vec::new();
            write(&records, "can0", TimeAxis::with_offset(0), &mut text).unwrap();
            prop_assert_eq!(read(text.as_slice()).unwrap().frames, records);
        }

        #[test]
        fn no_text_makes_it_panic(text in "[-() .#RT0-9A-Fa-f\\n]{0,60}", any in any::<String>()) {
            let _ = read(text.as_bytes());
            let _ = read(any.as_bytes());
        }
    }

    #[test]
    fn lines_of_can_utils_are_understood() {
        let text = "\
            (1436509052.249713) vcan0 181#2106E8030000\n\
            (1436509052.249714) vcan0 080#01 T\n\
            (1436509052.449847) can0 701#R\n\
            (1436509053.650713) can0 12345678#00\n\
            (1436509053.650713) can0 123##1112233\n\
            (1436509053.850870) can0 201#0F.00.10.27 R\n";
        let candump = read(text.as_bytes()).unwrap();
        assert_eq!((candump.frames.len(), candump.left_out), (3, 3));
        let [feedback, sync, command] = candump.frames.as_slice() else { panic!() };
        assert_eq!(feedback.at, Instant::from_nanoseconds(1_436_509_052_249_713_000));
        assert_eq!(feedback.direction, FrameDirection::Received);
        assert_eq!((sync.direction, sync.frame.data()), (FrameDirection::Sent, &[1][..]));
        assert_eq!(command.frame.data(), [0x0F, 0x00, 0x10, 0x27]);
    }

    #[test]
    fn a_wrong_line_is_named() {
        for wrong in
            ["hello", "(1.5) can0", "(1.5) can0 181#123", "(x) can0 181#", "(1.5) can0 181#00 X", "(1.5) can0 9FF#"]
        {
            let text = format!("(1.5) can0 181#00\n{wrong}\n");
            let error = read(text.as_bytes()).unwrap_err();
            assert!(error.to_string().starts_with(&format!("line 2: `{wrong}`")), "{error}");
        }
    }
}

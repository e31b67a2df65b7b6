//! `candump -L` files, as the can-utils write and read them: one frame a line.
//!
//! ```text
//! (1436509052.249713) can0 181#2106E8030000
//! ```
//!
//! Written with nine digits of the second, since the instants are known to the nanosecond; can-utils of 2023 and later read
//! both. Read with any number of digits, with LF or CRLF, a byte order mark, comments (`#`, `;`), and raw data length codes
//! (`181#0011223344556677_9`). What a drive's protocol does not use (remote frames, 29-bit identifiers, CAN FD, error frames)
//! is left out and counted. Lines that candump does not write, a last one without its end, and those in which it tells that
//! frames were dropped, are losses: what is whole is read.

use std::collections::BTreeMap;
use std::io::{self, BufRead, Read, Write};
use std::ops::ControlFlow;

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

/// The longest line that is read, bytes: one of CAN FD with dots has about 250.
const MOST_LINE_BYTES: usize = 1024;
/// A line with more bytes than this ends what is read: no tool writes such.
const MOST_SKIPPED_BYTES: usize = 1024 * 1024;
/// In a file of candump there is a frame among so many lines.
const LINES_WITHOUT_A_FRAME: usize = 1000;
/// So much of a line stands in a message, characters.
const SHOWN_CHARACTERS: usize = 60;
/// The byte order mark of UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// What a file told beside its frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Candump {
    /// Lines with frames that the drives' protocol does not use.
    pub left_out: usize,
    /// Lines that candump does not write: how many, and the first in words.
    pub unreadable: Option<Lines>,
    /// Lines in which candump tells that frames were dropped.
    pub dropped: Option<Lines>,
}

/// Lines of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lines {
    /// How many there are.
    pub count: usize,
    /// The number of the first, counted from 1.
    pub first: usize,
    /// Its text, shortened.
    pub text: String,
}

impl Lines {
    fn add(lines: &mut Option<Self>, number: usize, text: &str) {
        let lines = lines.get_or_insert_with(|| Self { count: 0, first: number, text: shortened(text) });
        lines.count += 1;
    }
}

impl Candump {
    /// What is missing, in words.
    pub fn losses(&self) -> Vec<String> {
        let unreadable = self.unreadable.as_ref().map(|Lines { count, first, text }| {
            format!("{count} lines are none of candump's, or cut, and left out; the first: line {first}: `{text}`")
        });
        let dropped = self.dropped.as_ref().map(|Lines { count, first, text }| {
            format!("candump tells {count} times that it dropped frames, first in line {first}: `{text}`")
        });
        unreadable.into_iter().chain(dropped).collect()
    }
}

/// Whose frames are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interface<'a> {
    /// Those of the only interface in the file.
    TheOnlyOne,
    /// Those of this interface.
    Named(&'a str),
}

/// Why a file cannot be read as one that candump wrote.
#[derive(Debug, thiserror::Error)]
pub enum CandumpError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// No line is one of candump's.
    #[error(
        "line {}: `{}`, expected a log of `uarm run`, or lines of candump -L such as `(1436509052.249713) can0 181#2106E803`",
        .0.first, .0.text
    )]
    NoCandump(Lines),
    /// There is nothing in it.
    #[error("there is no frame in it")]
    Empty,
    /// Frames of several interfaces, which are not one bus.
    #[error("frames of several interfaces: {0}; expected those of one")]
    Interfaces(String),
    /// No frame of the interface that was named.
    #[error("no frame of {named}; there are those of {found}")]
    NoInterface {
        /// The interface that was named.
        named: String,
        /// Those in the file.
        found: String,
    },
}

/// What a line holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Line<'a> {
    Frame { at: Instant, interface: &'a str, frame: Frame },
    LeftOut,
}

/// Reads a file and gives each frame of the interface that is wanted to `take`, in the order of the file, numbered from 0; instants
/// are times of day, or since boot, as the file has them. Holds one line at a time.
///
/// # Errors
/// [`CandumpError`] if it cannot be read, or is not a file of candump, or not of one interface; frames that were given before belong
/// to such a file.
pub fn read(
    input: impl BufRead,
    wanted: Interface<'_>,
    mut take: impl FnMut(FrameRecord),
) -> Result<Candump, CandumpError> {
    let mut candump = Candump::default();
    let mut sequence = 0_u32;
    let mut interfaces = BTreeMap::<String, usize>::new();
    for_each_line(input, |number, bytes| {
        let is_candump = number < LINES_WITHOUT_A_FRAME || !interfaces.is_empty() || candump.left_out > 0;
        let go_on = if is_candump { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
        let Ok(text) = std::str::from_utf8(bytes) else {
            Lines::add(&mut candump.unreadable, number, &String::from_utf8_lossy(bytes));
            return go_on;
        };
        let text = text.trim();
        if text.is_empty() || text.starts_with(['#', ';']) {
            return go_on;
        }
        match line(text) {
            // Its frame may have been longer.
            Some(_) if !bytes.ends_with(b"\n") => Lines::add(&mut candump.unreadable, number, text),
            Some(Line::Frame { at, interface, frame }) => {
                match interfaces.get_mut(interface) {
                    Some(count) => *count += 1,
                    None => drop(interfaces.insert(interface.to_owned(), 1)),
                }
                if matches!(wanted, Interface::TheOnlyOne) || wanted == Interface::Named(interface) {
                    take(FrameRecord { sequence, direction: direction(&frame), frame, at });
                    sequence = sequence.wrapping_add(1);
                }
            }
            Some(Line::LeftOut) => candump.left_out += 1,
            None if text.contains("DROPCOUNT") => Lines::add(&mut candump.dropped, number, text),
            None => Lines::add(&mut candump.unreadable, number, text),
        }
        go_on
    })?;
    check(candump, &interfaces, wanted)
}

fn check(
    candump: Candump,
    interfaces: &BTreeMap<String, usize>,
    wanted: Interface<'_>,
) -> Result<Candump, CandumpError> {
    if interfaces.is_empty() && candump.left_out == 0 {
        return Err(candump.unreadable.map_or(CandumpError::Empty, CandumpError::NoCandump));
    }
    let names = || {
        let names = interfaces.iter().map(|(name, count)| format!("{} ({count} frames)", shortened(name)));
        names.collect::<Vec<_>>().join(", ")
    };
    match wanted {
        Interface::TheOnlyOne if interfaces.len() > 1 => Err(CandumpError::Interfaces(names())),
        Interface::Named(named) if !interfaces.contains_key(named) => {
            Err(CandumpError::NoInterface { named: named.to_owned(), found: names() })
        }
        _ => Ok(candump),
    }
}

/// Gives each line with its number, counted from 1; of a longer one than [`MOST_LINE_BYTES`] its beginning. Ends where `take`
/// breaks off, and behind a line of more than [`MOST_SKIPPED_BYTES`].
fn for_each_line(mut input: impl BufRead, mut take: impl FnMut(usize, &[u8]) -> ControlFlow<()>) -> io::Result<()> {
    let limit = u64::try_from(MOST_LINE_BYTES).unwrap_or(u64::MAX);
    let mut line = Vec::with_capacity(MOST_LINE_BYTES);
    for number in 1.. {
        line.clear();
        if input.by_ref().take(limit).read_until(b'\n', &mut line)? == 0 {
            break;
        }
        let is_cut = line.len() == MOST_LINE_BYTES && !line.ends_with(b"\n");
        let text = if number == 1 { line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&line) } else { &line };
        if take(number, text).is_break() || (is_cut && skip_line(&mut input)?.is_break()) {
            break;
        }
    }
    Ok(())
}

/// Skips what is left of a line; breaks off if there is no end of it.
fn skip_line(input: &mut impl BufRead) -> io::Result<ControlFlow<()>> {
    let mut skipped = 0;
    while skipped < MOST_SKIPPED_BYTES {
        let buffer = input.fill_buf()?;
        let (count, is_end) = match buffer.iter().position(|byte| *byte == b'\n') {
            Some(position) => (position + 1, true),
            None => (buffer.len(), buffer.is_empty()),
        };
        input.consume(count);
        skipped += count;
        if is_end {
            return Ok(ControlFlow::Continue(()));
        }
    }
    Ok(ControlFlow::Break(()))
}

fn shortened(text: &str) -> String {
    let mut shown: String = text.chars().take(SHOWN_CHARACTERS).flat_map(char::escape_debug).collect();
    if text.chars().nth(SHOWN_CHARACTERS).is_some() {
        shown.push_str("...");
    }
    shown
}

fn line(text: &str) -> Option<Line<'_>> {
    let mut words = text.split_whitespace();
    let at = time(words.next()?.strip_prefix('(')?.strip_suffix(')')?)?;
    let interface = words.next()?;
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
    Some(Line::Frame { at, interface, frame: Frame::new(id, &bytes(without_raw_length(payload)?)?)? })
}

/// Of eight bytes candump can tell the raw data length code, 9 to F, behind them.
fn without_raw_length(payload: &str) -> Option<&str> {
    let Some((data, code)) = payload.split_once('_') else { return Some(payload) };
    matches!(code.as_bytes(), [b'9' | b'A'..=b'F' | b'a'..=b'f']).then_some(data)
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
    frames.iter().try_for_each(|record| write_frame(record, interface, axis, &mut output))?;
    output.flush()
}

/// Writes a frame as it would have been seen on `interface`.
///
/// # Errors
/// If the output cannot be written.
pub fn write_frame(record: &FrameRecord, interface: &str, axis: TimeAxis, output: &mut impl Write) -> io::Result<()> {
    let at = axis.at(record.at);
    let (seconds, nanoseconds) = (at / NANOSECONDS_PER_SECOND, at % NANOSECONDS_PER_SECOND);
    write!(output, "({seconds:010}.{nanoseconds:09}) {interface} {:03X}#", record.frame.id().as_raw())?;
    for byte in record.frame.data() {
        write!(output, "{byte:02X}")?;
    }
    writeln!(output)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Its frames, and what it told beside them.
    fn read_all(input: &[u8], wanted: Interface<'_>) -> Result<(Vec<FrameRecord>, Candump), CandumpError> {
        let mut frames = Vec::new();
        let candump = read(input, wanted, |frame| frames.push(frame))?;
        Ok((frames, candump))
    }

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
            let read = read_all(text.as_slice(), Interface::TheOnlyOne);
            match read {
                Ok((frames, _)) => prop_assert_eq!(frames, records),
                Err(error) => prop_assert!(records.is_empty(), "{error}"),
            }
        }

        #[test]
        fn no_text_makes_it_panic(text in "[-() .#_RT0-9A-Fa-f\\n]{0,60}", any in prop::collection::vec(any::<u8>(), 0..100)) {
            let _ = read_all(text.as_bytes(), Interface::TheOnlyOne);
            let _ = read_all(any.as_slice(), Interface::Named("can0"));
        }
    }

    #[test]
    fn lines_of_can_utils_are_understood() {
        let text = "\
            (1436509052.249713) vcan0 181#2106E8030000\n\
            (1436509052.249714) vcan0 080#01 T\n\
            (1436509052.449847) vcan0 701#R\n\
            (1436509053.650713) can0 12345678#00\n\
            (1436509053.650713) can0 123##1112233\n\
            (1436509053.850870) vcan0 201#0F.00.10.27 R\n";
        let (frames, candump) = read_all(text.as_bytes(), Interface::TheOnlyOne).unwrap();
        assert_eq!((frames.len(), candump.left_out), (3, 3));
        let [feedback, sync, command] = frames.as_slice() else { panic!() };
        assert_eq!(feedback.at, Instant::from_nanoseconds(1_436_509_052_249_713_000));
        assert_eq!(feedback.direction, FrameDirection::Received);
        assert_eq!((sync.direction, sync.frame.data()), (FrameDirection::Sent, &[1][..]));
        assert_eq!(command.frame.data(), [0x0F, 0x00, 0x10, 0x27]);
    }

    #[test]
    fn a_wrong_line_is_left_out_and_named() {
        let wrong_lines = [
            "hello",
            "(1.5) can0",
            "(1.5) can0 181#123",
            "(x) can0 181#",
            "(1.5) can0 181#00 X",
            "(1.5) can0 9FF#",
            "(1.5) can0 181#0011223344556677_8",
        ];
        for wrong in wrong_lines {
            let text = format!("(1.5) can0 181#00\n{wrong}\n(1.6) can0 181#01\n");
            let (frames, candump) = read_all(text.as_bytes(), Interface::TheOnlyOne).unwrap();
            assert_eq!((frames.len(), candump.left_out), (2, 0), "{wrong}");
            let losses = format!("1 lines are none of candump's, or cut, and left out; the first: line 2: `{wrong}`");
            assert_eq!(candump.losses(), [losses]);
            let error = read_all(format!("{wrong}\n").as_bytes(), Interface::TheOnlyOne).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("line 1: `{wrong}`, expected a log of `uarm run`, or lines")),
                "{error}"
            );
        }
    }

    #[test]
    fn what_editors_and_tools_add_changes_nothing() {
        let plain = "(1.5) can0 181#0011223344556677\n(1.6) can0 080#01\n";
        let expected = read_all(plain.as_bytes(), Interface::TheOnlyOne).unwrap();
        for text in [
            plain.replace('\n', "\r\n"),
            format!("\u{feff}{plain}"),
            format!("# a comment\n\n; another\n{plain}\n"),
            plain.replace("6677", "6677_9"),
            plain.replace("6677", "6677_F"),
        ] {
            assert_eq!(read_all(text.as_bytes(), Interface::TheOnlyOne).unwrap(), expected, "{text}");
        }
    }

    /// What is there may be the beginning of a longer frame.
    #[test]
    fn a_last_line_without_an_end_is_left_out() {
        for cut in ["(1.6) can0 202#0F00FBFF", "(1.6) can0 202#0F00", "(1.6) can0 202#0F0", "(1.6) ca"] {
            let (frames, candump) =
                read_all(format!("(1.5) can0 181#00\n{cut}").as_bytes(), Interface::TheOnlyOne).unwrap();
            assert_eq!(frames.len(), 1, "{cut}");
            assert!(candump.losses()[0].contains("line 2: `(1.6)"), "{:?}", candump.losses());
        }
    }

    #[test]
    fn dropped_frames_and_bytes_that_are_no_text_are_told() {
        let text = [
            &b"(1.5) can0 181#00\nDROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n\xff\xfe\n"[..],
            &[b'0'; 5000],
            b"\n(1.6) can0 181#01\n(1.7) can0 18",
        ]
        .concat();
        let (frames, candump) = read_all(text.as_slice(), Interface::TheOnlyOne).unwrap();
        assert_eq!(frames.len(), 2);
        let [unreadable, dropped] = candump.losses().try_into().unwrap();
        assert!(unreadable.starts_with("3 lines are none of candump's"), "{unreadable}");
        assert!(dropped.contains("line 2: `DROPCOUNT: dropped 3 CAN frames"), "{dropped}");
    }

    #[test]
    fn interfaces_are_told_apart() {
        let text = "(1.5) can0 181#00\n(1.6) can1 181#01\n(1.7) can0 181#02\n";
        let error = read_all(text.as_bytes(), Interface::TheOnlyOne).unwrap_err().to_string();
        assert_eq!(error, "frames of several interfaces: can0 (2 frames), can1 (1 frames); expected those of one");
        assert_eq!(read_all(text.as_bytes(), Interface::Named("can0")).unwrap().0.len(), 2);
        let error = read_all(text.as_bytes(), Interface::Named("can7")).unwrap_err().to_string();
        assert_eq!(error, "no frame of can7; there are those of can0 (2 frames), can1 (1 frames)");
    }
}

//! Standard output and standard error, whoever reads them, or nobody.
//!
//! A reader that has left, as `head` does, ends the output and nothing else: the command does its work, and its exit code is
//! that of the work. Any other failure of standard output, such as a full disk, is an error of the command. What standard error
//! does not take is lost. Signs that a terminal would obey, from a file's name or a robot's, are shown escaped.

use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::io::{self, ErrorKind, StdoutLock, Write};

use serde::Serialize;

/// What is written to standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Escapes {
    /// Text: `\u{1b}`.
    Text,
    /// JSON: `\u001b`.
    Json,
}

/// Standard output.
pub struct Output {
    stdout: StdoutLock<'static>,
    escapes: Escapes,
    reader_has_left: bool,
}

/// Standard output, for text.
pub fn output() -> Output {
    Output { stdout: io::stdout().lock(), escapes: Escapes::Text, reader_has_left: false }
}

/// Prints a value as JSON to standard output.
///
/// # Errors
/// If it cannot be written.
pub fn print_json(value: &impl Serialize) -> io::Result<()> {
    let mut output = Output { escapes: Escapes::Json, ..output() };
    serde_json::to_writer_pretty(&mut output, value)?;
    writeln!(output)?;
    output.flush()
}

impl Output {
    fn unless_left(&mut self, result: io::Result<()>) -> io::Result<()> {
        match result {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => self.reader_has_left = true,
            Err(error) => return Err(io::Error::new(error.kind(), format!("standard output: {error}"))),
            Ok(()) => {}
        }
        Ok(())
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if !self.reader_has_left {
            let written = self.stdout.write_all(&escaped(bytes, self.escapes));
            self.unless_left(written)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.reader_has_left {
            return Ok(());
        }
        let flushed = self.stdout.flush();
        self.unless_left(flushed)
    }
}

/// Tells standard error a line.
pub fn tell(line: impl fmt::Display) {
    let line = format!("{line}\n");
    // There is nobody else to tell.
    let _ = io::stderr().lock().write_all(&escaped(line.as_bytes(), Escapes::Text));
}

/// Writes over the line of standard error that the previous call wrote.
pub fn tell_again(text: impl fmt::Display) {
    let text = text.to_string();
    let mut stderr = io::stderr().lock();
    let _ = stderr.write_all(b"\r").and_then(|()| stderr.write_all(&escaped(text.as_bytes(), Escapes::Text)));
}

/// The text with what a terminal would obey escaped.
fn escaped(bytes: &[u8], escapes: Escapes) -> Cow<'_, [u8]> {
    if bytes.iter().all(|byte| matches!(byte, b' '..=b'~' | b'\n' | b'\t')) {
        return Cow::Borrowed(bytes);
    }
    let mut text = String::with_capacity(bytes.len());
    for letter in String::from_utf8_lossy(bytes).chars() {
        let code = u32::from(letter);
        // A `String` takes everything.
        let _ = match (is_obeyed(letter), escapes) {
            (false, _) => text.write_char(letter),
            (true, Escapes::Text) => write!(text, "\\u{{{code:x}}}"),
            (true, Escapes::Json) => write!(text, "\\u{code:04x}"),
        };
    }
    Cow::Owned(text.into_bytes())
}

/// A name with its line ends escaped, too: a file that somebody wrote cannot print lines of its own.
pub fn in_one_line(name: &str) -> String {
    name.replace('\n', "\\n").replace('\t', "\\t")
}

/// Control characters, and those that turn the direction of writing.
fn is_obeyed(letter: char) -> bool {
    match letter {
        '\n' | '\t' => false,
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        letter => letter.is_control(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str, escapes: Escapes) -> String {
        String::from_utf8(escaped(text.as_bytes(), escapes).into_owned()).unwrap()
    }

    #[test]
    fn what_a_terminal_would_obey_is_escaped() {
        for plain in ["a robot\n\tjoint 2", "Gelenk \u{f6}\u{b0}\u{2801}"] {
            assert_eq!(text(plain, Escapes::Text), plain);
        }
        let name = "red\u{1b}[31m\r\u{7f}\u{9b}\u{202e}";
        assert_eq!(text(name, Escapes::Text), "red\\u{1b}[31m\\u{d}\\u{7f}\\u{9b}\\u{202e}");
        assert_eq!(in_one_line("a\nb: ok\tc"), "a\\nb: ok\\tc");
        let json = format!("\"{}\"", text("a\u{9b}\u{7f}", Escapes::Json));
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), "a\u{9b}\u{7f}");
        assert_eq!(escaped(b"\xff.mcap", Escapes::Text).as_ref(), "\u{fffd}.mcap".as_bytes());
    }
}

//! Typed confirmations.

use std::io::BufRead;

use anyhow::Context;

use crate::console;

/// What somebody answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confirmation {
    /// As asked for.
    Given,
    /// Anything else.
    Refused,
}

/// Asks on standard error for `word` if `statement` is true, and reads the answer from `input`; does not ask if it was given on
/// the command line.
///
/// # Errors
/// If nobody can be asked, since standard input is no terminal.
pub fn confirm(
    statement: &str,
    word: &str,
    given: bool,
    terminal: bool,
    input: &mut impl BufRead,
) -> anyhow::Result<Confirmation> {
    if given {
        return Ok(Confirmation::Given);
    }
    anyhow::ensure!(terminal, "{statement}: nobody can be asked, standard input is no terminal; --yes confirms it");
    console::tell_again(format_args!("type `{word}` if {statement}: "));
    let mut answer = String::new();
    input.read_line(&mut answer).context("reading the answer")?;
    Ok(if answer.trim() == word { Confirmation::Given } else { Confirmation::Refused })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_word_itself_confirms() {
        let answer = |text: &str| confirm("all is well", "2", false, true, &mut text.as_bytes()).unwrap();
        assert_eq!(answer("2\n"), Confirmation::Given);
        for text in ["", "\n", "yes\n", "22\n"] {
            assert_eq!(answer(text), Confirmation::Refused, "{text:?}");
        }
    }

    #[test]
    fn without_a_terminal_only_the_command_line_confirms() {
        let mut nothing: &[u8] = b"2\n";
        assert!(confirm("all is well", "2", false, false, &mut nothing).unwrap_err().to_string().contains("--yes"));
        assert_eq!(confirm("all is well", "2", true, false, &mut nothing).unwrap(), Confirmation::Given);
    }
}

//! The commands in documents, run.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::markdown::{Block, Document, Marker, root};

/// Runs the blocks with this marker, those of one document in one new folder below `folder`, which has the robot files. A
/// block of `sh` is a script, which must succeed; in one of `console` the lines behind `$ ` are commands, and what stands
/// below each is what it prints on standard output. Gives the number of blocks.
pub fn run(marker: Marker, folder: &Path) -> usize {
    let mut number = 0;
    for document in Document::all() {
        let blocks: Vec<_> = document.blocks().into_iter().filter(|block| block.marker == Some(marker)).collect();
        if blocks.is_empty() {
            continue;
        }
        number += blocks.len();
        let scratch = scratch(&document, folder);
        for block in &blocks {
            match block.language.as_deref() {
                Some("sh") => {
                    shell(&block.lines.join("\n"), &scratch, &block.place);
                }
                Some("console") => session(block, &scratch),
                other => panic!("{}: language {other:?}, expected sh or console", block.place),
            }
        }
    }
    number
}

fn scratch(document: &Document, folder: &Path) -> PathBuf {
    let scratch = folder.join(document.path.file_stem().unwrap());
    // Of an earlier test run; a log is never overwritten.
    let _ = std::fs::remove_dir_all(&scratch);
    std::fs::create_dir_all(scratch.join("robots")).unwrap();
    let entries = std::fs::read_dir(root().join("robots")).unwrap();
    for path in entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_file()) {
        std::fs::copy(&path, scratch.join("robots").join(path.file_name().unwrap())).unwrap();
    }
    scratch
}

/// Runs a script with `uarm` in its path, and gives its standard output.
fn shell(script: &str, folder: &Path, place: &str) -> String {
    let binaries = Path::new(env!("CARGO_BIN_EXE_uarm")).parent().unwrap();
    let path = format!("{}:{}", binaries.display(), std::env::var("PATH").unwrap());
    let output =
        Command::new("bash").args(["-euc", script]).env("PATH", path).current_dir(folder).output().expect("bash");
    let standard_output = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success(),
        "{place}: {}\n{standard_output}{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    standard_output
}

fn session(block: &Block, folder: &Path) {
    let mut lines = block.lines.iter().peekable();
    while let Some(line) = lines.next() {
        let command = line.strip_prefix("$ ").unwrap_or_else(|| panic!("{}: `{line}`, expected `$ `", block.place));
        let mut shown = String::new();
        while let Some(line) = lines.next_if(|line| !line.starts_with("$ ")) {
            shown += &format!("{line}\n");
        }
        let printed = shell(command, folder, &block.place);
        assert_eq!(printed, shown, "{}: `{command}` prints the left, the document shows the right", block.place);
    }
}

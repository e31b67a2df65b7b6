//! Documents, and the blocks of code in them.
#![allow(dead_code, reason = "each test binary uses a part of it")]

use std::path::{Path, PathBuf};

/// A Markdown file of the repository.
pub struct Document {
    /// Its path from the top of the repository.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

/// What stands before a block: whether a test runs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// `<!-- run -->`: run wherever tests run.
    Run,
    /// `<!-- run: vcan -->`: run where the interface vcan0 is up.
    RunVcan,
    /// `<!-- not run: why -->`.
    NotRun,
}

/// A block of code.
pub struct Block {
    /// File and line of its first line.
    pub place: String,
    /// What stands behind the fence; nothing for an indented block.
    pub language: Option<String>,
    /// Whether it is run.
    pub marker: Option<Marker>,
    /// Its lines, without the fence's indentation.
    pub lines: Vec<String>,
}

/// The top of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

impl Document {
    /// All documents: at the top, in `docs`, and the README of each crate.
    pub fn all() -> Vec<Self> {
        let mut paths = vec![];
        for folder in ["", "docs"] {
            paths.extend(
                entries(&root().join(folder)).into_iter().filter(|path| path.extension() == Some("md".as_ref())),
            );
        }
        paths.extend(entries(&root().join("crates")).iter().map(|folder| folder.join("README.md")));
        assert!(paths.len() > 10, "{paths:?}");
        paths.iter().map(|path| Self::read(path)).collect()
    }

    /// A document.
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Self { path: path.strip_prefix(root()).unwrap().to_owned(), text }
    }

    /// Its blocks of code. Indented lines count as one only where they hold a command of `uarm`: they cannot be marked.
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        let mut marker = None;
        let mut lines = self.text.lines().enumerate();
        while let Some((number, line)) = lines.next() {
            let place = format!("{}:{}", self.path.display(), number + 1);
            let content = line.trim_start();
            let indentation = line.len() - content.len();
            if let Some(language) = content.strip_prefix("```") {
                let end = |line: &str| line.trim() == "```";
                let body: Vec<String> = lines
                    .by_ref()
                    .map(|(_, line)| line)
                    .take_while(|line| !end(line))
                    .map(|line| line.get(indentation..).unwrap_or_default().to_owned())
                    .collect();
                blocks.push(Block { place, language: Some(language.to_owned()), marker, lines: body });
                marker = None;
            } else if let Some(comment) = content.strip_prefix("<!-- ").and_then(|text| text.strip_suffix(" -->")) {
                marker = match comment {
                    "run" => Some(Marker::Run),
                    "run: vcan" => Some(Marker::RunVcan),
                    _ if comment.strip_prefix("not run: ").is_some_and(|why| !why.is_empty()) => Some(Marker::NotRun),
                    _ => None,
                };
            } else if indentation >= 4 && is_uarm_command(content) {
                blocks.push(Block { place, language: None, marker: None, lines: vec![content.to_owned()] });
            } else if !content.is_empty() {
                marker = None;
            }
        }
        blocks
    }

    /// Its lines that are no code.
    pub fn prose(&self) -> Vec<&str> {
        let mut in_code = false;
        self.text
            .lines()
            .filter(|line| {
                let fence = line.trim_start().starts_with("```");
                in_code ^= fence;
                !in_code && !fence
            })
            .collect()
    }
}

impl Block {
    /// Is there a command of `uarm` in it?
    pub fn has_uarm_command(&self) -> bool {
        let is_shell =
            matches!(self.language.as_deref(), None | Some("" | "sh" | "bash" | "shell" | "console" | "text"));
        is_shell && self.lines.iter().any(|line| is_uarm_command(line.trim_start()))
    }
}

fn is_uarm_command(line: &str) -> bool {
    let line = line.strip_prefix("$ ").unwrap_or(line);
    line.split_whitespace().next().is_some_and(|word| word == "uarm" || word.ends_with("/uarm"))
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

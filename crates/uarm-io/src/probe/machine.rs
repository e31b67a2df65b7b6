//! Where facts are read from.

use std::path::{Path, PathBuf};

/// A machine to look at: the running one, or a folder laid out like one.
#[derive(Clone, Debug)]
pub struct Machine {
    root: PathBuf,
    source: Source,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Running,
    Folder,
}

impl Machine {
    /// The running machine.
    pub fn this() -> Self {
        Self { root: PathBuf::from("/"), source: Source::Running }
    }

    /// A machine whose `/proc`, `/sys` and `/boot` lie below a folder.
    pub fn in_folder(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), source: Source::Folder }
    }

    pub(super) fn is_running(&self) -> bool {
        self.source == Source::Running
    }

    pub(super) fn path(&self, absolute: &str) -> PathBuf {
        self.root.join(absolute.trim_start_matches('/'))
    }

    /// The text of a file without surrounding white space; `None` if it is absent or not readable.
    pub(super) fn text(&self, absolute: &str) -> Option<String> {
        std::fs::read_to_string(self.path(absolute)).ok().map(|text| text.trim().to_owned())
    }

    pub(super) fn number<T: core::str::FromStr>(&self, absolute: &str) -> Option<T> {
        self.text(absolute)?.parse().ok()
    }

    /// The names in a folder, sorted; empty if it is absent.
    pub(super) fn names(&self, absolute: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(absolute)).into_iter().flatten().flatten();
        let mut names: Vec<_> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort();
        names
    }

    pub(super) fn exists(&self, absolute: &str) -> bool {
        Path::exists(&self.path(absolute))
    }
}

//! The structure of the workspace, checked on its sources: which crate may depend on which, no circle between the files of
//! a crate, and no command-line flag named by a library.
//!
//! Each check has tests of its own that it finds what it is there to find.

mod crates;
mod cycles;
mod flags;
mod imports;
mod modules;

use crates::Workspace;
use imports::Imports;
use modules::Modules;
use std::path::Path;

#[test]
fn each_crate_depends_on_nothing_but_what_it_may() {
    let findings = Workspace::load().findings();
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

#[test]
fn no_crate_has_a_circle_between_its_files() {
    let workspace = Workspace::load();
    let mut findings = Vec::new();
    for (name, root) in workspace.source_roots() {
        let modules = Modules::read(&root, &|path: &Path| std::fs::read_to_string(path).ok());
        let imports = Imports::of(&modules);
        println!("{name}: {} files, {} imports between them", modules.files().len(), imports.len());
        findings.extend(cycles::shortest(&imports).iter().map(|cycle| format!("{name}: {}", describe(cycle))));
    }
    assert!(findings.is_empty(), "{} circles between files:\n{}", findings.len(), findings.join("\n"));
}

fn describe(cycle: &[&imports::Import]) -> String {
    let steps = cycle.iter().map(|step| format!("\n    {} -> {}  ({})", step.from, step.to, step.path));
    format!("{} files{}", cycle.len(), steps.collect::<String>())
}

#[test]
fn no_library_names_a_command_line_flag() {
    let workspace = Workspace::load();
    let mut findings = Vec::new();
    for (_, root) in workspace.library_roots() {
        let modules = Modules::read(&root, &|path: &Path| std::fs::read_to_string(path).ok());
        for (file, syntax) in modules.files() {
            findings.extend(flags::named_in(syntax).iter().map(|text| format!("{file}: {text}")));
        }
    }
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

/// The compiler that the tests run with is the oldest one that is known to do.
#[test]
fn each_readme_states_the_oldest_rust_that_is_tested() {
    let stated = env!("CARGO_PKG_RUST_VERSION");
    for (name, root) in Workspace::load().library_roots() {
        let readme = root.ancestors().nth(2).expect("crates/NAME/src/lib.rs").join("README.md");
        let text = std::fs::read_to_string(&readme).unwrap_or_else(|error| panic!("{}: {error}", readme.display()));
        assert!(
            text.contains(stated),
            "{name}: README.md says nothing of Rust {stated}, the rust-version of the workspace"
        );
    }
}

//! What documents list, and what there is of it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::markdown::{Document, root};

/// Crates by name, each with its folder and the crates of the workspace that it uses.
type Crates = BTreeMap<String, (String, BTreeSet<String>)>;

/// What stands in a row's cells.
fn cells(row: &str) -> Vec<&str> {
    row.trim_matches('|').split(" | ").map(str::trim).collect()
}

/// What stands between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The table under "Crates" in the README.
pub fn crates_in_readme() -> Crates {
    let readme = Document::read(&root().join("README.md"));
    let (_, table) = readme.text.split_once("\n## Crates\n").expect("a section Crates");
    let table = table.split("\n## ").next().unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| ["));
    rows.map(|row| {
        let cells = cells(row);
        let name = quoted(cells[0]).next().expect("a name").to_owned();
        let folder = cells[0].split_once("](").expect("a link").1.trim_end_matches(')').to_owned();
        (name, (folder, quoted(cells[2]).map(ToOwned::to_owned).collect()))
    })
    .collect()
}

/// The packages of the workspace, but for the fuzz targets. The binary's folder is `src`.
pub fn crates_of_cargo() -> Crates {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let packages: Vec<_> =
        metadata["packages"].as_array().unwrap().iter().filter(|package| package["name"] != "uarm-fuzz").collect();
    let names: BTreeSet<_> = packages.iter().map(|package| text(&package["name"])).collect();
    packages
        .iter()
        .map(|package| {
            let manifest = text(&package["manifest_path"]);
            let folder = Path::new(&manifest).parent().unwrap().strip_prefix(root()).unwrap();
            let folder = if folder == Path::new("") { "src".to_owned() } else { folder.display().to_string() };
            let dependencies = package["dependencies"].as_array().unwrap().iter();
            let normal = dependencies.filter(|dependency| dependency["kind"].is_null());
            let used = normal.map(|dependency| text(&dependency["name"])).filter(|name| names.contains(name));
            (text(&package["name"]), (folder, used.collect()))
        })
        .collect()
}

/// Tests that the theory and the description of logs name; only the beginning of a name that ends in "…".
pub fn named_tests() -> Vec<String> {
    let theory = Document::read(&root().join("docs/theory.md"));
    let (_, table) = theory.text.split_once("\n## 11. Which test checks what\n").expect("section 11");
    let table = table.split("\n## ").next().unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| ") && line.contains('`'));
    let mut names: Vec<_> =
        rows.flat_map(|row| quoted(cells(row)[2]).map(ToOwned::to_owned).collect::<Vec<_>>()).collect();
    let recording = Document::read(&root().join("docs/recording.md"));
    let (_, table) = recording.text.split_once("| what fails |").expect("the table of what fails");
    let rows = table.lines().take_while(|line| !line.is_empty()).filter_map(|row| cells(row).last().copied());
    names.extend(
        rows.flat_map(|cell| quoted(cell).map(|name| name.trim_end_matches('…').to_owned()).collect::<Vec<_>>()),
    );
    names
}

/// The text of all sources of tests.
pub fn rust_sources() -> String {
    fn collect(folder: &Path, text: &mut String) {
        for entry in std::fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(&path, text);
            } else if path.extension() == Some("rs".as_ref()) {
                *text += &std::fs::read_to_string(path).unwrap();
            }
        }
    }
    let mut text = String::new();
    for folder in ["src", "tests", "crates"] {
        collect(&root().join(folder), &mut text);
    }
    text
}

/// The first two columns of the table in section 10 of `docs/wire.md`.
pub fn questions_in_wire() -> Vec<(String, String)> {
    let wire = Document::read(&root().join("docs/wire.md"));
    let (_, section) = wire.text.split_once("\n## 10. ").expect("a section 10");
    let section = section.split("\n## ").next().unwrap();
    let rows = section.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    rows.take_while(|line| line.starts_with('|'))
        .map(|row| {
            let cells = cells(row);
            (cells[0].to_owned(), cells[1].to_owned())
        })
        .collect()
}

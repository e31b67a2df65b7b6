//! Which crate of the workspace may depend on which, from `cargo metadata`. Normal dependencies only: what a crate's tests
//! and build scripts use is its own affair.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a crate may depend on.
struct Rule {
    name: &'static str,
    /// The crates of the workspace that it may name as a dependency.
    may_use: &'static [&'static str],
    /// Crates that it must not reach, not even through others.
    must_not_reach: &'static [&'static str],
}

const RULES: [Rule; 12] = [
    Rule { name: "dem-model", may_use: &[], must_not_reach: &["clap"] },
    Rule { name: "hinf-control", may_use: &["dem-model"], must_not_reach: &["clap"] },
    Rule { name: "uarm-io", may_use: &[], must_not_reach: &["clap"] },
    Rule {
        name: "uarm-loop",
        may_use: &["dem-model", "hinf-control", "uarm-io"],
        must_not_reach: &["clap", "sim", "uarm-sim", "mcap", "toml"],
    },
    Rule {
        name: "uarm-log",
        may_use: &["dem-model", "hinf-control", "uarm-io", "uarm-loop"],
        must_not_reach: &["clap", "sim", "uarm-sim"],
    },
    Rule { name: "uarm-eds", may_use: &[], must_not_reach: &["clap", "toml"] },
    Rule { name: "uarm-urdf", may_use: &["dem-model"], must_not_reach: &["clap", "toml"] },
    Rule { name: "uarm-plot", may_use: &[], must_not_reach: &["clap"] },
    Rule { name: "sim", may_use: &["dem-model", "hinf-control", "uarm-io"], must_not_reach: &["clap"] },
    Rule { name: "uarm-sim", may_use: &["dem-model", "hinf-control", "uarm-io"], must_not_reach: &["clap"] },
    Rule { name: "uarm-identify", may_use: &["dem-model", "uarm-sim"], must_not_reach: &["clap", "toml"] },
    Rule { name: "anfis", may_use: &[], must_not_reach: &["clap"] },
];

/// External crates that one crate alone may name as a dependency.
const RESERVED: [(&str, &str); 5] =
    [("mcap", "uarm-log"), ("prost", "uarm-log"), ("foxglove", "uarm-log"), ("clap", ROOT), ("clap_complete", ROOT)];

/// The package at the top of the workspace, which may use everything.
const ROOT: &str = "uarm";

/// The fuzz targets, which nobody uses.
const FUZZING: &str = "uarm-fuzz";

/// The packages, each with the names of its normal dependencies.
pub struct Workspace {
    /// Packages of the workspace, with the root file of each target that is not a test, bench or example.
    members: BTreeMap<String, Vec<PathBuf>>,
    /// By the name of the package; versions do not matter here.
    dependencies: BTreeMap<String, BTreeSet<String>>,
}

impl Workspace {
    /// Asks cargo.
    pub fn load() -> Self {
        let output = Command::new(env!("CARGO"))
            .args(["metadata", "--format-version", "1", "--locked"])
            .args(["--filter-platform", "x86_64-unknown-linux-gnu"])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Self::from_metadata(&serde_json::from_slice(&output.stdout).unwrap())
    }

    fn from_metadata(metadata: &Value) -> Self {
        let packages = metadata["packages"].as_array().unwrap();
        let name_of: BTreeMap<&str, &str> =
            packages.iter().map(|package| (text(&package["id"]), text(&package["name"]))).collect();
        let workspace: BTreeSet<&str> = metadata["workspace_members"].as_array().unwrap().iter().map(text).collect();
        let members = packages
            .iter()
            .filter(|package| workspace.contains(text(&package["id"])))
            .map(|package| (text(&package["name"]).to_owned(), source_roots(package)))
            .collect();
        let mut dependencies: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for node in metadata["resolve"]["nodes"].as_array().unwrap() {
            let of = dependencies.entry(name_of[text(&node["id"])].to_owned()).or_default();
            for dependency in node["deps"].as_array().unwrap() {
                let is_normal = dependency["dep_kinds"].as_array().unwrap().iter().any(|kind| kind["kind"].is_null());
                if is_normal {
                    of.insert(name_of[text(&dependency["pkg"])].to_owned());
                }
            }
        }
        Self { members, dependencies }
    }

    /// Each library and binary of the workspace: its package, and its root file.
    pub fn source_roots(&self) -> Vec<(&str, PathBuf)> {
        self.members.iter().flat_map(|(name, roots)| roots.iter().map(|root| (name.as_str(), root.clone()))).collect()
    }

    /// Each library beside the root package.
    pub fn library_roots(&self) -> Vec<(&str, PathBuf)> {
        self.source_roots().into_iter().filter(|(name, _)| *name != ROOT && *name != FUZZING).collect()
    }

    /// What is not as it must be.
    pub fn findings(&self) -> Vec<String> {
        let mut findings = Vec::new();
        for name in self.members.keys().filter(|name| *name != ROOT && *name != FUZZING) {
            match RULES.iter().find(|rule| rule.name == name) {
                Some(rule) => findings.extend(self.against(rule)),
                None => findings.push(format!("{name}: tests/architecture/crates.rs has no rule for this crate")),
            }
        }
        for (reserved, owner) in RESERVED {
            let users =
                self.members.keys().filter(|name| *name != owner && self.dependencies[*name].contains(reserved));
            // A crate that is not there yet owns nothing.
            if self.members.contains_key(owner) {
                findings.extend(users.map(|name| format!("{name} depends on {reserved}; only {owner} may")));
            }
        }
        findings
    }

    fn against(&self, rule: &Rule) -> Vec<String> {
        let direct = self.dependencies[rule.name]
            .iter()
            .filter(|used| self.members.contains_key(*used) && !rule.may_use.contains(&used.as_str()))
            .map(|used| format!("{} depends on {used}; it may use {:?} of this workspace", rule.name, rule.may_use));
        let reached = rule
            .must_not_reach
            .iter()
            .filter_map(|forbidden| self.way(rule.name, forbidden))
            .map(|way| format!("{} must not reach {}: {}", rule.name, way[way.len() - 1], way.join(" -> ")));
        direct.chain(reached).collect()
    }

    /// The shortest chain of dependencies from one package to another.
    fn way(&self, from: &str, to: &str) -> Option<Vec<String>> {
        let mut ways = vec![vec![from.to_owned()]];
        let mut seen = BTreeSet::from([from.to_owned()]);
        while !ways.is_empty() {
            let mut longer = Vec::new();
            for way in ways {
                let end = &way[way.len() - 1];
                if end == to {
                    return Some(way);
                }
                for next in self.dependencies.get(end).into_iter().flatten() {
                    if seen.insert(next.clone()) {
                        longer.push(way.iter().chain([next]).cloned().collect());
                    }
                }
            }
            ways = longer;
        }
        None
    }
}

fn text(value: &Value) -> &str {
    value.as_str().expect("a text in cargo's metadata")
}

fn source_roots(package: &Value) -> Vec<PathBuf> {
    let is_source = |target: &&Value| {
        target["kind"].as_array().unwrap().iter().any(|kind| matches!(text(kind), "lib" | "bin" | "proc-macro"))
    };
    let targets = package["targets"].as_array().unwrap().iter();
    targets.filter(is_source).map(|target| Path::new(text(&target["src_path"])).to_owned()).collect()
}

/// A workspace of which only the dependencies are told.
fn fixture(dependencies: &[(&str, &[&str])], members: &[&str]) -> Workspace {
    let own = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<BTreeSet<_>>();
    Workspace {
        members: members.iter().map(|name| ((*name).to_owned(), Vec::new())).collect(),
        dependencies: dependencies.iter().map(|(name, used)| ((*name).to_owned(), own(used))).collect(),
    }
}

#[test]
fn a_forbidden_dependency_is_found() {
    let workspace = fixture(&[("dem-model", &["uarm-io", "nalgebra"]), ("uarm-io", &[])], &["dem-model", "uarm-io"]);
    assert_eq!(workspace.findings(), ["dem-model depends on uarm-io; it may use [] of this workspace"]);
}

#[test]
fn a_forbidden_crate_is_found_behind_others() {
    let dependencies: [(&str, &[&str]); 3] = [("uarm-loop", &["serde"]), ("serde", &["toml"]), ("toml", &[])];
    let findings = fixture(&dependencies, &["uarm-loop"]).findings();
    assert_eq!(findings, ["uarm-loop must not reach toml: uarm-loop -> serde -> toml"]);
}

#[test]
fn a_reserved_crate_is_found_with_another_crate() {
    let dependencies: [(&str, &[&str]); 2] = [("uarm", &["mcap", "clap"]), ("uarm-log", &["mcap"])];
    let findings = fixture(&dependencies, &["uarm", "uarm-log"]).findings();
    assert_eq!(findings, ["uarm depends on mcap; only uarm-log may"]);
}

#[test]
fn a_crate_without_a_rule_is_found() {
    let findings = fixture(&[("uarm-new", &[])], &["uarm-new"]).findings();
    assert_eq!(findings, ["uarm-new: tests/architecture/crates.rs has no rule for this crate"]);
}

#[test]
fn dependencies_of_tests_and_build_scripts_do_not_count() {
    let metadata = serde_json::json!({
        "packages": [
            { "id": "a", "name": "anfis", "targets": [{ "kind": ["lib"], "src_path": "anfis/src/lib.rs" }] },
            { "id": "d", "name": "dem-model", "targets": [{ "kind": ["lib"], "src_path": "dem-model/src/lib.rs" }] },
        ],
        "workspace_members": ["a", "d"],
        "resolve": { "nodes": [
            { "id": "a", "deps": [{ "pkg": "d", "dep_kinds": [{ "kind": "dev" }, { "kind": "build" }] }] },
            { "id": "d", "deps": [] },
        ] },
    });
    let mut workspace = Workspace::from_metadata(&metadata);
    assert_eq!(workspace.findings(), [""; 0]);
    workspace.dependencies.get_mut("anfis").unwrap().insert("dem-model".to_owned());
    assert_eq!(workspace.findings().len(), 1);
}

//! Stamps the commit into the binary for `uarm --version` and the logs, and compiles the messages of the logs.

use std::path::{Path, PathBuf};
use std::process::Command;

use prost_build::Config;
use protox::prost::Message;

/// One `.proto` file per kind of message; each stands alone, so that its descriptor set is the schema in the log.
const MESSAGES: [&str; 6] = ["can", "control", "drives", "fault", "keyframe", "timing"];

/// Messages that `uarm show --json` and `uarm monitor --json` print as they are.
const SHOWN_AS_JSON: [&str; 4] = [".uarm.CanHealth", ".uarm.NodeHealth", ".uarm.InterfaceHealth", ".uarm.Fault"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    stamp_commit();
    compile_messages()
}

fn stamp_commit() {
    println!("cargo::rerun-if-changed=.git/HEAD");
    println!("cargo::rerun-if-changed=.git/refs/heads");
    let commit = Command::new("git")
        .args(["describe", "--always", "--dirty", "--exclude=*"])
        .output()
        .ok()
        .filter(|output| output.status.success())
        .and_then(|output| String::from_utf8(output.stdout).ok())
        .map_or_else(|| "unknown".to_owned(), |text| text.trim().to_owned());
    println!("cargo::rustc-env=UARM_COMMIT={commit}");
}

fn compile_messages() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rerun-if-changed=proto");
    let output = PathBuf::from(std::env::var("OUT_DIR")?);
    let files = MESSAGES.map(|name| format!("uarm/{name}.proto"));
    for (name, file) in MESSAGES.iter().zip(&files) {
        let mut descriptors = protox::compile([file], ["proto"])?;
        for file in &mut descriptors.file {
            file.source_code_info = None;
        }
        std::fs::write(output.join(Path::new(name).with_extension("fds")), descriptors.encode_to_vec())?;
    }
    let mut config = Config::new();
    for message in SHOWN_AS_JSON {
        config.type_attribute(message, "#[derive(serde::Serialize)]");
    }
    config.compile_fds(protox::compile(files, ["proto"])?)?;
    Ok(())
}

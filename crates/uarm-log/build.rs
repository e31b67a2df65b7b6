//! Compiles the messages of the logs, and the descriptor set of each, which is its schema in the log.

use std::path::{Path, PathBuf};

use prost_build::Config;
use protox::prost::Message;

/// One `.proto` file per kind of message; each stands alone, so that its descriptor set is the schema in the log.
const MESSAGES: [&str; 6] = ["can", "control", "drives", "fault", "keyframe", "timing"];

/// Messages that other programs print as JSON as they are.
const SHOWN_AS_JSON: [&str; 4] = [".uarm.CanHealth", ".uarm.NodeHealth", ".uarm.InterfaceHealth", ".uarm.Fault"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
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

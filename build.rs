//! Stamps the commit into the binary for `uarm --version` and the logs.

use std::path::Path;
use std::process::Command;

fn main() {
    // Where a worktree has them. A path that does not exist would have everything compiled anew each time.
    let head = git(&["rev-parse", "--git-path", "HEAD"]);
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]).and_then(|name| git(&["rev-parse", "--git-path", &name]));
    let files = ["build.rs".to_owned()].into_iter().chain(head).chain(branch);
    for file in files.filter(|file| Path::new(file).exists()) {
        println!("cargo::rerun-if-changed={file}");
    }
    let commit = git(&["describe", "--always", "--dirty", "--exclude=*"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=UARM_COMMIT={commit}");
}

/// What git says, if it is there and this is a repository.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
}

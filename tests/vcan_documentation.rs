//! The commands in documents that need a CAN interface, run where `vcan0` is up: see `tests/documentation`.

#[path = "documentation/commands.rs"]
mod commands;
#[path = "documentation/markdown.rs"]
mod markdown;

#[test]
fn commands_on_vcan0_succeed() {
    // In a guest the build folder is read-only; its temporary folder is not.
    let number = commands::run(markdown::Marker::RunVcan, &std::env::temp_dir().join("documentation"));
    assert!(number > 0, "no block was found");
}

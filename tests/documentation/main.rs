//! The documents say what is so: their commands run, their links lead somewhere, and what they list is there.

mod commands;
mod links;
mod lists;
mod markdown;

use std::path::PathBuf;

use markdown::{Document, Marker};

#[test]
fn every_block_of_uarm_commands_says_whether_it_is_run() {
    let unmarked: Vec<_> = Document::all()
        .iter()
        .flat_map(|document| document.blocks())
        .filter(|block| block.marker.is_none() && block.has_uarm_command())
        .map(|block| block.place)
        .collect();
    assert!(
        unmarked.is_empty(),
        "commands of uarm in blocks without `<!-- run -->`, `<!-- run: vcan -->` or `<!-- not run: why -->` before them, \
         or without a fence: {unmarked:#?}"
    );
}

#[test]
fn commands_that_need_no_hardware_do_what_the_documents_show() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("documentation");
    let number = commands::run(Marker::Run, &folder);
    assert!(number > 5, "only {number} blocks were found");
}

#[test]
fn links_between_documents_lead_somewhere() {
    let broken: Vec<_> = Document::all().iter().flat_map(links::broken).collect();
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn the_readmes_table_of_crates_is_what_cargo_says() {
    assert_eq!(lists::crates_in_readme(), lists::crates_of_cargo());
}

#[test]
fn the_table_of_what_a_drive_must_know_is_what_is_asked_of_it() {
    let asked = uarm_io::drive::plan::Question::ALL;
    let asked: Vec<_> = asked.iter().map(|question| (question.title().into(), question.objects().into())).collect();
    assert_eq!(lists::questions_in_wire(), asked);
}

#[test]
fn tests_that_the_documents_name_exist() {
    let named = lists::named_tests();
    assert!(named.len() > 50, "only {} tests were found", named.len());
    let sources = lists::rust_sources();
    let missing: Vec<_> = named.iter().filter(|name| !sources.contains(&format!("fn {name}"))).collect();
    assert!(missing.is_empty(), "{missing:#?}");
}

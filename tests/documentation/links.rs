//! Links between documents.

use super::markdown::{Document, root};

/// Its relative links that lead to no file, or to no heading of a document, each with what is wrong.
pub fn broken(document: &Document) -> Vec<String> {
    let prose = document.prose().join("\n");
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
    targets
        .filter(|target| !target.contains("://"))
        .filter_map(|target| {
            let why = check(document, target)?;
            Some(format!("{}: {target}: {why}", document.path.display()))
        })
        .collect()
}

fn check(document: &Document, target: &str) -> Option<&'static str> {
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let here = root().join(&document.path);
    let path = if file.is_empty() { here } else { here.parent().unwrap().join(file) };
    if !path.exists() {
        return Some("no such file");
    }
    let has_heading =
        || Document::read(&path.canonicalize().unwrap()).prose().into_iter().any(|line| slug(line) == anchor);
    (!anchor.is_empty() && !has_heading()).then_some("no such heading")
}

/// The anchor of a heading, as GitHub makes it; empty for other lines.
fn slug(line: &str) -> String {
    let Some(title) = line.strip_prefix('#') else { return String::new() };
    title
        .trim_start_matches('#')
        .trim()
        .to_lowercase()
        .chars()
        .filter(|character| character.is_alphanumeric() || " -_".contains(*character))
        .map(|character| if character == ' ' { '-' } else { character })
        .collect()
}

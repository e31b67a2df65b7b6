//! Command-line flags in the texts and the documentation of a library: flags are the affair of the program that has them.

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::File;

/// Each string, and each line of documentation, in which a flag is named. Tests are left out.
pub fn named_in(file: &File) -> Vec<String> {
    let mut found = Vec::new();
    for item in file.items.iter().filter(|item| !super::modules::is_test(super::modules::attributes_of(item))) {
        search(item.to_token_stream(), &mut found);
    }
    for attribute in &file.attrs {
        search(attribute.to_token_stream(), &mut found);
    }
    found
}

fn search(tokens: TokenStream, found: &mut Vec<String>) {
    for token in tokens {
        match token {
            TokenTree::Group(group) => search(group.stream(), found),
            TokenTree::Literal(literal) => {
                let text = literal.to_string();
                if names_flag(&text) {
                    found.push(text);
                }
            }
            TokenTree::Ident(_) | TokenTree::Punct(_) => {}
        }
    }
}

/// Two dashes and a letter at the beginning of a word.
fn names_flag(text: &str) -> bool {
    text.match_indices("--").any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + 2..].chars().next();
        after.is_some_and(|letter| letter.is_ascii_lowercase())
            && !before.is_some_and(|letter| letter == '-' || letter.is_alphanumeric())
    })
}

#[test]
fn a_flag_is_found_in_texts_and_documentation_only() {
    let found = |text: &str| named_in(&syn::parse_str(text).unwrap()).len();
    assert_eq!(found("fn f() { println!(\"try `--rt prefer`\") }"), 1);
    assert_eq!(found("/// As the flag `--can` says.\nfn f() {}"), 1);
    assert_eq!(found("//! With --json.\n"), 1);
    assert_eq!(found("const HELP: &str = r#\"--json\"#;"), 1);
    assert_eq!(found("fn f(x: f64) -> f64 { 1.0 - --x } // not even --here"), 0);
    assert_eq!(found("/// One--two, |---|---x|, a -- b.\nfn f() {}"), 0);
    assert_eq!(found("#[cfg(test)] mod tests { const ARGUMENT: &str = \"--json\"; }"), 0);
}

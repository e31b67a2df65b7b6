//! Bytes to sections of keys and values.

use crate::problem::Problem;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A key's value, and where it stands.
#[derive(Clone, Debug)]
pub struct Entry {
    pub value: String,
    pub line: usize,
}

/// A section.
#[derive(Clone, Debug)]
pub struct Section {
    /// As written, without brackets.
    pub name: String,
    pub line: usize,
    /// By key in lower case: CiA 306 does not tell cases apart.
    pub entries: BTreeMap<String, Entry>,
}

impl Section {
    /// The entry of `key` (lower case) if it says something: an empty value counts as none.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.get(key).filter(|entry| !entry.value.is_empty())
    }
}

/// CiA 306 files are ASCII; makers write names in UTF-8 or Latin-1.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text.strip_prefix('\u{feff}').unwrap_or(text)),
        Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
    }
}

/// The sections of a file. Of two sections of one name, and of two keys of one name, the first holds, as in Windows' own reader of
/// such files; a second one that says something else is a problem.
pub fn sections(file: &str, text: &str, problems: &mut Vec<Problem>) -> Vec<Section> {
    let mut sections: Vec<Section> = Vec::new();
    for (index, raw) in text.lines().enumerate() {
        let (line, content) = (index + 1, raw.trim());
        let section = sections.last().map(|section| section.name.clone()).unwrap_or_default();
        let mut refuse = |key: &str, value: &str, expected: &str| {
            problems.push(Problem {
                file: file.to_owned(),
                line,
                section: section.clone(),
                key: key.to_owned(),
                value: value.to_owned(),
                expected: expected.to_owned(),
            });
        };
        if content.is_empty() || content.starts_with([';', '#']) {
            continue;
        }
        if let Some(rest) = content.strip_prefix('[') {
            match rest.split_once(']') {
                Some((name, _)) => {
                    sections.push(Section { name: name.trim().to_owned(), line, entries: BTreeMap::new() });
                }
                None => refuse("", content, "a section in brackets"),
            }
            continue;
        }
        match (content.split_once('='), sections.last_mut()) {
            (Some((key, value)), Some(section)) => {
                let (key, value) = (key.trim().to_lowercase(), value.trim());
                match section.get(&key) {
                    Some(first) if first.value != value && !value.is_empty() => {
                        refuse(&key, value, &format!("{:?} as before, which holds", first.value));
                    }
                    Some(_) => {}
                    None => drop(section.entries.insert(key, Entry { value: value.to_owned(), line })),
                }
            }
            (Some(_), None) => refuse("", content, "a section before the first key"),
            (None, _) => refuse("", content, "key=value"),
        }
    }
    sections
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Vec<Section>, Vec<String>) {
        let mut problems = Vec::new();
        let sections = sections("a.eds", text, &mut problems);
        (sections, problems.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn spaces_comments_and_line_ends_do_not_matter() {
        let (sections, problems) =
            read("; a comment\r\n  [1000] ; device\r\n\tDataType = 0x7 \r\n  # no key\r\nDefaultValue=\r\n");
        assert_eq!(problems, [""; 0]);
        assert_eq!(sections.len(), 1);
        assert_eq!(sections[0].name, "1000");
        assert_eq!(sections[0].get("datatype").unwrap().value, "0x7");
        assert_eq!(sections[0].get("datatype").unwrap().line, 3);
        assert!(sections[0].get("defaultvalue").is_none(), "empty is as good as absent");
    }

    #[test]
    fn the_first_of_two_keys_holds_and_a_line_without_a_key_swallows_nothing() {
        let (sections, problems) =
            read("[1000]\nDataType=7\nnothing\nDataType=5\nAccessType=ro\nAccessType=ro\nC:\\EDS\\\nName=x\n");
        assert_eq!(sections[0].get("datatype").unwrap().value, "7");
        assert_eq!(sections[0].get("name").unwrap().value, "x");
        assert_eq!(
            problems,
            [
                "a.eds, line 3, [1000]: found \"nothing\", expected key=value",
                "a.eds, line 4, [1000] datatype: found \"5\", expected \"7\" as before, which holds",
                "a.eds, line 7, [1000]: found \"C:\\\\EDS\\\\\", expected key=value",
            ]
        );
    }

    #[test]
    fn latin_1_utf_8_and_a_byte_order_mark_are_read() {
        assert_eq!(decode(b"Name=M\xFCnchen"), "Name=M\u{fc}nchen");
        assert_eq!(decode("Name=M\u{fc}nchen".as_bytes()), "Name=M\u{fc}nchen");
        assert_eq!(decode(b"\xEF\xBB\xBF[1000]"), "[1000]");
    }
}

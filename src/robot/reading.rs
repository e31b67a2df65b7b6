//! TOML into a type, and the fields in it that the type does not know.

use std::path::Path;

use serde::de::DeserializeOwned;

use super::error::RobotError;

/// A file as written, and the fields in it that are not known; `name` is what messages call the file.
///
/// # Errors
/// [`RobotError::Syntax`] if it is no TOML, or a field is missing or of another type.
pub fn read<T: DeserializeOwned>(name: &Path, text: &str) -> Result<(T, Vec<String>), RobotError> {
    let syntax = |error| RobotError::Syntax { file: name.to_owned(), error: Box::new(error) };
    let mut unknown = Vec::new();
    let deserializer = toml::Deserializer::parse(text).map_err(syntax)?;
    // What may be left out has a step `?` of its own in the path.
    let mut note = |path: serde_ignored::Path<'_>| unknown.push(path.to_string().replace(".?", ""));
    // One type for all `T`: else the compiler makes every part of a file anew for each.
    let note: &mut dyn FnMut(serde_ignored::Path<'_>) = &mut note;
    let file = serde_ignored::deserialize(deserializer, note);
    let file = file.map_err(syntax)?;
    Ok((file, unknown))
}

//! What robot and joints are called: in messages, reports and logs.

use super::error::{Checker, RobotError};
use super::file::Joint;

/// The most characters of a name: it stands in lines of a report.
const MOST_CHARACTERS: usize = 100;

/// Checks that each name is one line that can be read, and that no two joints share one.
///
/// # Errors
/// [`RobotError::Field`] for the first name that is not.
pub fn check(robot: &str, joints: &[Joint], check: &Checker<'_>) -> Result<(), RobotError> {
    readable("name".to_owned(), robot, check)?;
    for (index, joint) in joints.iter().enumerate() {
        let field = format!("joints[{index}].name");
        if joints.iter().take(index).any(|earlier| earlier.name == joint.name) {
            return Err(check.refuse(field, format!("{:?}", joint.name), "a name that no other joint has"));
        }
        readable(field, &joint.name, check)?;
    }
    Ok(())
}

fn readable(field: String, name: &str, check: &Checker<'_>) -> Result<(), RobotError> {
    let is_line = !name.contains(['\n', '\u{2028}', '\u{2029}']);
    if !name.trim().is_empty() && is_line && name.chars().count() <= MOST_CHARACTERS {
        return Ok(());
    }
    Err(check.refuse(
        field,
        format!("{name:?}"),
        format!("a name in one line, of at most {MOST_CHARACTERS} characters"),
    ))
}

#[cfg(test)]
mod tests {
    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};
    use std::path::Path;

    fn refused(from: &str, to: &str) -> String {
        assert!(BUILT_IN.contains(from), "{from}");
        let text = BUILT_IN.replacen(from, to, 1);
        Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).unwrap_err().to_string()
    }

    #[test]
    fn joints_and_robots_have_names_of_their_own() {
        let second = "name = \"joint 2\"";
        for wrong in ["", " ", "joint 2\\nL2 0.0000"] {
            let expected = format!(
                "test.toml: joints[1].name = \"{wrong}\": expected a name in one line, of at most 100 characters"
            );
            assert_eq!(refused(second, &format!("name = \"{wrong}\"")), expected);
        }
        assert_eq!(
            refused(second, "name = \"base\""),
            "test.toml: joints[1].name = \"base\": expected a name that no other joint has"
        );
        let robot = BUILT_IN.lines().find(|line| line.starts_with("name = ")).unwrap();
        let message = refused(robot, &format!("name = \"{}\"", "x".repeat(101)));
        assert!(
            message.starts_with("test.toml: name = \"xxx") && message.ends_with("of at most 100 characters"),
            "{message}"
        );
    }
}

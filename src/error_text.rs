//! Errors in words.

/// An error with its causes, the outermost first. A cause that the text before it already tells is not told again.
pub fn with_causes(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text.push_str(": ");
            text.push_str(&cause);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[derive(Debug, thiserror::Error)]
    #[error("robot.toml: cannot be read: {source}")]
    struct Read {
        source: std::io::Error,
    }

    #[test]
    fn each_cause_is_told_once() {
        let read = || Read { source: std::io::Error::other("the disk is gone") };
        let error = anyhow::Error::new(read());
        assert_eq!(with_causes(&error), "robot.toml: cannot be read: the disk is gone");
        let error = Err::<(), _>(std::io::Error::other("the disk is gone")).context("--csv").unwrap_err();
        assert_eq!(with_causes(&error), "--csv: the disk is gone");
        let error = anyhow::Error::new(read()).context("--robot");
        assert_eq!(with_causes(&error), "--robot: robot.toml: cannot be read: the disk is gone");
    }
}

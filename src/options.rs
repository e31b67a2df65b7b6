//! Choices on command lines: what [`Choice`] names, as clap reads and lists it.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use uarm_loop::choice::Choice;

/// A parser for a choice, which lists each value with its description in the help text.
pub fn choice<C: Choice>() -> impl TypedValueParser<Value = C> {
    let values = C::ALL.iter().map(|choice| PossibleValue::new(choice.name()).help(choice.description()));
    PossibleValuesParser::new(values).try_map(|name| C::from_name(&name).ok_or("not one of the possible values"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hinf_control::Law;

    #[test]
    fn a_choice_is_read_by_its_name() {
        let command = clap::Command::new("test").arg(clap::Arg::new("law").value_parser(choice::<Law>()));
        let law = |text: &str| {
            command.clone().try_get_matches_from(["test", text]).map(|found| found.get_one("law").copied())
        };
        assert_eq!(law("fuzzy-model").unwrap(), Some(Law::FuzzyModel));
        let error = law("pid").unwrap_err().to_string();
        assert!(error.contains("possible values: nonlinear, adaptive"), "{error}");
    }
}

//! Settings as robot files hold them.

use hinf_control::laws::{adaptive, computed_torque, fuzzy_model, neural_model, nonlinear};
use hinf_control::{AdaptiveBaseAcceleration, BaseAcceleration, ControllerSettings, Law, NominalForm, SymmetricWeight};

/// The controllers of the paper's robot file.
const FILE: &str = r#"
attenuation_level = 2.0         # gamma; paper
# Are the entries Q1 and Q2 themselves ("factors", as the text says) or the blocks Q1'Q1 and Q2'Q2 of Q ("blocks", which
# fits Table 4 clearly better)? Open in the paper.
reading = "blocks"
r = [0.9, 2.5]                  # R, the same for all; paper

[nonlinear]
q1 = [0.64, 0.64]
q2 = [9.0, 7.0]
# How the base acceleration in E = M_mb q_b'' + C_mb q_b' is had: "measured", "eliminated" (eqs. 20 and 21), "omitted",
# "reduced", "reduced-momentum" (docs/theory.md).
base_acceleration = "eliminated"

[adaptive]
q1 = [0.64, 0.64]
q2 = [9.0, 7.0]
z = 10.0                        # Z = z I
# On hardware, and with --adaptation bounded, no adapted parameter goes further than this from its start. Chosen: five to
# eight times as far as any of them goes in the paper's task on the simulated robot.
bound = 0.05
base_acceleration = "omitted"   # "measured", "eliminated" or "omitted"

[neural]
q1 = [0.64, 0.64]
q2 = [9.0, 7.0]
z = 10.0
bound = 0.1

[neural-model]
q1 = [4.0, 4.0]
q2 = [9.0, 7.0]
z = 100.0
bound = 0.1
model_form = "paper"            # "paper" (F, eq. 37) or "reduced" (docs/theory.md)

[fuzzy]
q1 = [1.0, 1.0]
q2 = [9.0, 7.0]
z = 0.8
bound = 1.0
firing = "minimum"              # "minimum" (eq. 39) or "product"

[fuzzy-model]
q1 = [4.0, 4.0]
q2 = [25.0, 7.0]
z = 20.0
bound = 0.3
firing = "minimum"
model_form = "paper"

# Our seventh, for comparison: PD plus computed torque, with the feedback gains of controller 1.
[computed-torque]
model_form = "paper"
"#;

#[test]
fn the_paper_s_file_holds_the_defaults() {
    let settings: ControllerSettings = toml::from_str(FILE).unwrap();
    // The file chooses another mode than the law's default.
    let adaptive = adaptive::Settings { base_acceleration: AdaptiveBaseAcceleration::Omitted, ..Default::default() };
    assert_eq!(settings, ControllerSettings { adaptive, ..Default::default() });
}

#[test]
fn settings_come_back_from_their_file() {
    let settings = ControllerSettings {
        r: SymmetricWeight::Full([[0.9, 0.1], [0.1, 2.5]]),
        nonlinear: nonlinear::Settings { base_acceleration: BaseAcceleration::ReducedMomentum, ..Default::default() },
        neural_model: neural_model::Settings { model_form: NominalForm::Reduced, ..Default::default() },
        ..Default::default()
    };
    let text = toml::to_string(&settings).unwrap();
    assert!(text.contains("model_form = \"active-joints\"") && text.contains("reduced-momentum"), "{text}");
    assert_eq!(toml::from_str::<ControllerSettings>(&text).unwrap(), settings);
}

#[test]
fn every_law_has_a_section_of_its_name() {
    let text = toml::to_string(&ControllerSettings::default()).unwrap();
    let table: toml::Table = text.parse().unwrap();
    for law in Law::ALL {
        assert!(table.get(law.name()).is_some_and(toml::Value::is_table), "{}", law.name());
    }
}

#[test]
fn a_law_without_a_section_has_its_default() {
    let settings: ControllerSettings =
        toml::from_str("attenuation_level = 2.0\nreading = \"blocks\"\nr = [0.9, 2.5]").unwrap();
    assert_eq!(settings.fuzzy_model, fuzzy_model::Settings::default());
    assert_eq!(settings.computed_torque, computed_torque::Settings { model_form: NominalForm::ActiveJoints });
    assert_eq!(settings, ControllerSettings::default());
}

#[test]
fn weights_are_diagonals_or_matrices_of_numbers() {
    let read = |text: &str| toml::from_str::<std::collections::BTreeMap<String, SymmetricWeight>>(text);
    let weight = |text: &str| read(text).map(|table| table["r"]);
    assert_eq!(weight("r = [1.5, 2]"), Ok(SymmetricWeight::Diagonal([1.5, 2.0])));
    assert_eq!(weight("r = [[1, 0.5], [0.5, 2.0]]"), Ok(SymmetricWeight::Full([[1.0, 0.5], [0.5, 2.0]])));
    for wrong in ["r = [1.0]", "r = [1.0, 2.0, 3.0]", "r = [[1.0, 2.0], 3.0]", "r = 1.0", "r = [\"a\", \"b\"]"] {
        let message = weight(wrong).unwrap_err().to_string();
        assert!(message.contains("a diagonal [a, b] or a symmetric matrix"), "{wrong}: {message}");
    }
}

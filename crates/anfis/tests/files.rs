//! Sets in files: with the feature `serde`, in any format.

use anfis::{Anfis, Firing, InputSets, PremiseSets, Universe};

fn sets() -> PremiseSets {
    let velocity = InputSets::grid("velocity error", "deg/s", Universe::new(-20.0, 20.0).unwrap(), 3).unwrap();
    let position = InputSets::grid("position error", "deg", Universe::new(-2.0, 0.5).unwrap(), 3).unwrap();
    PremiseSets::new(Firing::Minimum, vec![velocity, position]).unwrap()
}

#[test]
fn what_is_written_is_read_again() {
    let file = toml::to_string(&sets()).unwrap();
    for expected in ["firing = \"minimum\"", "name = \"velocity error\"", "universe = [-2.0, 0.5]", "half_width = 10.0"]
    {
        assert!(file.contains(expected), "{expected} is not in:\n{file}");
    }
    assert_eq!(toml::from_str::<PremiseSets>(&file).unwrap(), sets());
    let system = Anfis::new(sets(), vec![0.5; 27]).unwrap();
    assert_eq!(serde_json::from_str::<Anfis>(&serde_json::to_string(&system).unwrap()).unwrap(), system);
}

#[test]
fn illegal_sets_cannot_be_read() {
    let file = |bell: &str| {
        format!("firing = 'minimum'\n[[inputs]]\nname = 'x'\nunit = 'm'\nuniverse = [0, 1]\nsets = [{{ {bell} }}]")
    };
    let refusal = |bell: &str| toml::from_str::<PremiseSets>(&file(bell)).unwrap_err().to_string();
    assert!(toml::from_str::<PremiseSets>(&file("half_width = 0.5, steepness = 2, centre = 0.0")).is_ok());
    let message = refusal("half_width = 0.5, steepness = -2, centre = 0.0");
    assert!(message.contains("steepness -2 of a bell"), "{message}");
    let message = refusal("half_width = 0.5, steepness = 2, centre = 0.0, height = 1");
    assert!(message.contains("unknown field `height`"), "{message}");
    let empty = "firing = 'minimum'\ninputs = []";
    let message = toml::from_str::<PremiseSets>(empty).unwrap_err().to_string();
    assert!(message.contains("0 inputs"), "{message}");
}

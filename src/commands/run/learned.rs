//! What a robot file says in words of its drives, and what the drives said of themselves, before they have power.

use uarm_io::drive::DriveIdentity;
use uarm_io::drive::objects::{MAXIMUM_CURRENT, MAXIMUM_TORQUE};
use uarm_io::drive::plan::{Finding, Findings, Verdict};
use uarm_io::drive::survey::Survey;

use crate::robot::Robot;

/// The reasons that the robot file gives for what a drive lacks.
pub fn reasons<const J: usize, const N: usize>(robot: &Robot<J, N>) -> Vec<String> {
    let of_joint = |joint: &crate::robot::file::Joint| {
        let text = |what: &str, reason: &Option<String>| {
            reason.as_ref().map(|reason| format!("  {}: {what}, as the robot file says: {reason}", joint.name))
        };
        [
            text("6007h need not be set", &joint.drive.without_6007h),
            text("its command timeout is its watchdog, tested", &joint.drive.watchdog_test),
        ]
    };
    robot.file.joints.iter().flat_map(of_joint).flatten().collect()
}

/// Prints on stderr what was learned of a drive; called by the master before any drive has power.
pub fn print(node: u8, survey: &Survey, findings: &Findings) {
    for line in lines(node, survey, findings) {
        eprintln!("{line}");
    }
}

/// Prints on stderr what an ODrive axis says that it is.
pub fn print_identity(node: u8, identity: &DriveIdentity) {
    eprintln!("  node {node}: {identity}");
}

fn lines(node: u8, survey: &Survey, findings: &Findings) -> Vec<String> {
    let limit = |object| survey.get(object).answer.to_string();
    let own = format!(
        "  node {node}: its own limits, per mille of the rated: torque 6072h {}, current 6073h {}",
        limit(&MAXIMUM_TORQUE),
        limit(&MAXIMUM_CURRENT)
    );
    let notes = findings.iter().filter(|finding| finding.verdict != Verdict::Works);
    let told = |finding: &Finding| format!("  node {node}: {finding}");
    let identity = format!("  node {node}: {}", survey.identity());
    [identity, own].into_iter().chain(notes.map(told)).collect()
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::path::Path;

    use uarm_io::drive::objects::Object;
    use uarm_io::drive::plan::{Question, Remedy, Wanted};
    use uarm_io::drive::survey::{Answer, Answered, ObjectSource};

    use super::*;
    use crate::robot::BUILT_IN;
    use crate::robot::overrides::Overrides;

    struct Limits;

    impl ObjectSource for Limits {
        type Error = Infallible;

        fn ask(&mut self, object: &Object) -> Result<Answered, Infallible> {
            let answer = match (object.index, object.subindex) {
                (0x1018, 1) => Answer::Number(0x9A),
                (0x1018, 4) => Answer::Number(1001),
                (0x6072, 0) => Answer::Number(500),
                _ => Answer::Absent,
            };
            Ok(Answered::by_drive(answer))
        }
    }

    #[test]
    fn which_drive_it_is_its_own_limits_and_what_is_to_be_known_are_told() {
        let Ok(survey) = Survey::of(&mut Limits, [], |_, _| false);
        let finding = |verdict, remedy| Finding {
            question: Question::TorqueLimits,
            object: MAXIMUM_TORQUE.address(),
            found: Answer::Number(500),
            wanted: Wanted::Number(1000),
            remedy,
            verdict,
        };
        let findings = [finding(Verdict::Works, Remedy::None), finding(Verdict::WorksWith, Remedy::Note("it cuts"))];
        assert_eq!(
            lines(2, &survey, &findings.into_iter().collect()),
            [
                "  node 2: vendor 0000009Ah, serial number 1001",
                "  node 2: its own limits, per mille of the rated: torque 6072h 500 (1F4h), current 6073h absent",
                "  node 2: 6072h:00 (max torque) is 500 (1F4h), expected 1000 (3E8h): it cuts",
            ]
        );
    }

    #[test]
    fn the_robot_files_reasons_are_told() {
        let text = BUILT_IN.replacen(
            "rated_torque_nm = 0.2,",
            "rated_torque_nm = 0.2, without_6007h = \"the brake has its own relay\",",
            1,
        );
        let robot = Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).unwrap();
        assert_eq!(
            reasons(&robot),
            ["  base: 6007h need not be set, as the robot file says: the brake has its own relay"]
        );
        assert_eq!(reasons(&Robot::load(None).unwrap()), Vec::<String>::new());
    }
}

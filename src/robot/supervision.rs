//! How counts and torques are held against the model: checked, with defaults that follow the robot.

use std::sync::Arc;

use uarm_io::time::Duration;
use uarm_loop::dimensions;
use uarm_loop::period::Period;
use uarm_loop::robot::Joint;
use uarm_loop::supervision::model::MomentumModel;
use uarm_loop::supervision::settings::{Bandwidth, ModelError, ResidualTime, SupervisionSettings, TorqueAllowance};

use super::error::{Checker, RobotError};
use super::file::{self, SupervisionMode};

/// What the file says, and defaults for what it does not; nothing if the supervision is off.
pub(super) fn check<const J: usize, const N: usize>(
    supervision: &file::Supervision,
    model: Arc<dyn MomentumModel<J>>,
    joints: &[Joint; J],
    period: Period,
    check: &Checker<'_>,
) -> Result<Option<SupervisionSettings<J>>, RobotError> {
    let bandwidth = bandwidth(supervision, period, check)?;
    let model_error = match supervision.model_error {
        None => ModelError::default(),
        Some(found) => {
            ModelError::new(found).ok_or_else(|| check.refuse("supervision.model_error", found, "0 to 1"))?
        }
    };
    let residual_time = match supervision.residual_ms {
        None => ResidualTime::default(),
        Some(found) => ResidualTime::new(Duration::from_millis(found.into())).ok_or_else(|| {
            let expected = format!("1 to {}", ResidualTime::LONGEST.as_millis());
            check.refuse("supervision.residual_ms", found, expected)
        })?,
    };
    let allowances = allowances::<J, N>(supervision, joints, check)?;
    let settings = SupervisionSettings { model, bandwidth, model_error, residual_time, allowances };
    Ok((supervision.mode == SupervisionMode::On).then_some(settings))
}

fn bandwidth(supervision: &file::Supervision, period: Period, check: &Checker<'_>) -> Result<Bandwidth, RobotError> {
    let Some(found) = supervision.bandwidth_rad_per_s else { return Ok(Bandwidth::of_period(period.seconds(1))) };
    let [least, most] = Bandwidth::RANGE;
    let field = "supervision.bandwidth_rad_per_s";
    let bandwidth = Bandwidth::new(found).ok_or_else(|| check.refuse(field, found, format!("{least} to {most}")))?;
    let most = 1.0 / period.seconds(1);
    if found > most {
        return Err(check.refuse(field, found, format!("at most {most:.0}, one radian in a period")));
    }
    Ok(bandwidth)
}

fn allowances<const J: usize, const N: usize>(
    supervision: &file::Supervision,
    joints: &[Joint; J],
    check: &Checker<'_>,
) -> Result<[Option<TorqueAllowance>; J], RobotError> {
    let Some(torques) = &supervision.unmodelled_torque_nm else {
        return Ok(joints.each_ref().map(|joint| TorqueAllowance::of_limit(joint.torque_limit)));
    };
    if torques.len() != N {
        let expected = format!("{N}, one for each active joint");
        return Err(check.refuse("supervision.unmodelled_torque_nm", format!("{} values", torques.len()), expected));
    }
    let mut allowances = [None; J];
    let driven = allowances.iter_mut().zip(joints).skip(dimensions::passive::<J, N>());
    for (((allowance, joint), found), index) in driven.zip(torques.iter().copied()).zip(0..) {
        let refuse =
            |expected: String| Err(check.refuse(format!("supervision.unmodelled_torque_nm[{index}]"), found, expected));
        let Some(torque) = TorqueAllowance::new(found) else { return refuse("above zero".to_owned()) };
        // What takes all of a joint's torque would hide that it does not move.
        if found >= joint.torque_limit {
            return refuse(format!("less than limits.torque_nm of the joint, {}", joint.torque_limit));
        }
        *allowance = Some(torque);
    }
    Ok(allowances)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use uarm_loop::supervision::settings::TorqueAllowance;

    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};

    fn with(table: &str) -> Result<Robot, String> {
        let (before, after) = BUILT_IN.split_once("mode = \"on\"\n").unwrap();
        let (_, after) = after.split_once("[bus]").unwrap();
        let text = format!("{before}{table}\n[bus]{after}");
        Robot::parse(Path::new("test.toml"), &text, &Overrides::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn what_the_file_says_is_taken_and_the_rest_follows_the_robot() {
        let settings = with("unmodelled_torque_nm = [0.1, 0.07]").unwrap().description.supervision.unwrap();
        let allowances = settings.allowances.map(|allowance| allowance.map(TorqueAllowance::get));
        assert_eq!(allowances, [None, Some(0.1), Some(0.07)]);
        assert_eq!(settings.bandwidth.get(), 50.0);
        assert!(with("mode = \"off\"").unwrap().description.supervision.is_none());
        let by_limit = with("").unwrap().description.supervision.unwrap().allowances;
        let three_quarters = Some(0.75 * 0.2);
        assert_eq!(by_limit.map(|joint| joint.map(TorqueAllowance::get)), [None, three_quarters, three_quarters]);
    }

    #[test]
    fn what_is_out_of_range_is_refused_by_name() {
        for (table, field) in [
            ("unmodelled_torque_nm = [0.1, 0.0]", "supervision.unmodelled_torque_nm[1] = 0: expected above zero"),
            (
                "unmodelled_torque_nm = [0.1, 0.2]",
                "supervision.unmodelled_torque_nm[1] = 0.2: expected less than limits.torque_nm of the joint, 0.2",
            ),
            ("model_error = 1.5", "supervision.model_error = 1.5: expected 0 to 1"),
            ("bandwidth_rad_per_s = 0.5", "supervision.bandwidth_rad_per_s = 0.5: expected 1 to 500"),
            ("bandwidth_rad_per_s = 400", "supervision.bandwidth_rad_per_s = 400: expected at most 333"),
            ("residual_ms = 0", "supervision.residual_ms = 0: expected 1 to 1000"),
            ("mode = \"maybe\"", "on"),
        ] {
            let message = with(table).unwrap_err();
            assert!(message.contains(field), "{table}: {message}");
        }
    }
}

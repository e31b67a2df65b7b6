//! What a count and a per mille are: scale factors of the law, which are compared and never corrected.

use super::finding::{Finding, Question, Remedy, Verdict, Wanted};
use super::planner::{Planner, setting};
use crate::drive::objects::{self, Object};
use crate::drive::survey::{Access, Answer};
use crate::drive::wishes::{Resolution, TorqueReference};
use crate::encoder::CountsPerRevolution;
use crate::torque::TorqueUnit;

const READ_AT_START: &str = "it is read at start, and must then be so";
const ONE_IS_WRONG: &str = "correct the robot file or the drive: one of them is wrong";
/// µN·m in a mN·m.
const MICRO_IN_MILLI: i64 = 1000;

impl Planner<'_> {
    pub(super) fn resolution(&mut self) -> Finding {
        let increments = &objects::ENCODER_INCREMENTS;
        match self.drive.resolution {
            Resolution::Standard => self.standard_resolution(self.drive.counts_per_revolution),
            Resolution::Stated => {
                let row = self.row(Question::Resolution, increments, Wanted::Words("anything: the robot file says it"));
                if row.found.is_there() { row.noting("the drive has 608Fh, and it is not compared") } else { row }
            }
            Resolution::Object { address, equals } => {
                let found = self.survey.at(address).answer;
                let wanted = Wanted::Number(equals);
                let row = Finding { object: address, found, ..self.row(Question::Resolution, increments, wanted) };
                match found {
                    Answer::Number(value) if value == equals => row,
                    Answer::Unstated => row.noting(READ_AT_START),
                    _ => row.with(Verdict::Cannot, Remedy::RobotFile(ONE_IS_WRONG)),
                }
            }
        }
    }

    fn standard_resolution(&mut self, counts: u32) -> Finding {
        let (increments, revolutions) = (&objects::ENCODER_INCREMENTS, &objects::ENCODER_REVOLUTIONS);
        let wanted = i64::from(counts);
        let row = self.row(Question::Resolution, increments, Wanted::Number(wanted));
        match (self.answer(increments), self.answer(revolutions)) {
            (Answer::Absent, _) => row.with(Verdict::WorksWith, Remedy::ResolutionStated),
            (Answer::Number(found), Answer::Number(turns)) if turns > 0 && Some(found) == wanted.checked_mul(turns) => {
                row
            }
            (Answer::Number(found), Answer::Number(1) | Answer::Absent) if found == wanted => row,
            (Answer::Unstated, _) | (Answer::Number(_), Answer::Unstated) => row.noting(READ_AT_START),
            (Answer::Number(found), Answer::Number(1)) => self.other_resolution(row, found, wanted),
            (Answer::Number(found), Answer::Number(turns)) => {
                // Several revolutions that cannot be written are those of the drive, as a ratio.
                let whole = found.checked_rem(turns) == Some(0);
                match found.checked_div(turns).filter(|_| whole).and_then(counts_per_revolution) {
                    Some(counts) if self.answered(revolutions).access != Access::ReadWrite => {
                        row.with(Verdict::WorksWith, Remedy::CountsPerRevolution(counts))
                    }
                    _ => {
                        let row = self.row(Question::Resolution, revolutions, Wanted::Number(1));
                        self.to_write(row, revolutions, 1)
                    }
                }
            }
            _ => row.with(Verdict::Cannot, Remedy::RobotFile(ONE_IS_WRONG)),
        }
    }

    /// A dictionary's default may be set; what a drive itself says is more likely right than the robot file.
    fn other_resolution(&mut self, row: Finding, found: i64, wanted: i64) -> Finding {
        if self.answered(&objects::ENCODER_INCREMENTS).access == Access::ReadWrite {
            return self.to_write(row, &objects::ENCODER_INCREMENTS, wanted);
        }
        match counts_per_revolution(found) {
            Some(counts) => row.with(Verdict::WorksWith, Remedy::CountsPerRevolution(counts)),
            None => self.to_write(row, &objects::ENCODER_INCREMENTS, wanted),
        }
    }

    /// The row with the remedy that the robot file writes `wanted`; it cannot work where that cannot be.
    fn to_write(&self, row: Finding, object: &Object, wanted: i64) -> Finding {
        match setting(object, wanted) {
            Some(setting) if self.answered(object).access.may_write() => {
                row.with(Verdict::WorksWith, Remedy::Write(setting))
            }
            _ => row.with(Verdict::Cannot, Remedy::RobotFile(ONE_IS_WRONG)),
        }
    }

    pub(super) fn rated_torque(&mut self) -> Finding {
        match self.drive.torque_reference {
            TorqueReference::RatedTorque => self.standard_rated_torque(),
            TorqueReference::StatedTorque => self.row(
                Question::RatedTorque,
                &objects::RATED_TORQUE,
                Wanted::Words("anything: the robot file says it"),
            ),
            TorqueReference::RatedCurrent { milliamperes } => {
                let wanted = i64::from(milliamperes);
                let row = self.row(Question::RatedTorque, &objects::RATED_CURRENT, Wanted::Number(wanted));
                match row.found {
                    Answer::Number(found) if found == wanted => row,
                    Answer::Unstated => row.noting(READ_AT_START),
                    Answer::Number(found) => match u32::try_from(found) {
                        Ok(found)
                            if found > 0 && self.answered(&objects::RATED_CURRENT).access != Access::ReadWrite =>
                        {
                            row.with(Verdict::WorksWith, Remedy::RatedCurrent(found))
                        }
                        _ => self.to_write(row, &objects::RATED_CURRENT, wanted),
                    },
                    _ => row.with(Verdict::WorksWith, Remedy::TorqueStated),
                }
            }
        }
    }

    fn standard_rated_torque(&mut self) -> Finding {
        let rated = self.drive.rated_torque;
        let wanted = i64::from(rated.object_value());
        let row = self.row(Question::RatedTorque, &objects::RATED_TORQUE, Wanted::Number(wanted));
        let in_micro = rated.unit() == TorqueUnit::MillinewtonMetre;
        match row.found {
            Answer::Number(found) if found == wanted => row,
            Answer::Number(found) if in_micro && Some(found) == wanted.checked_mul(MICRO_IN_MILLI) => {
                row.with(Verdict::WorksWith, Remedy::MicronewtonMetres)
            }
            Answer::Absent => row.with(Verdict::WorksWith, Remedy::TorqueStated),
            Answer::Unstated => row.noting(READ_AT_START),
            Answer::Number(found) => match u32::try_from(found) {
                Ok(found) if found > 0 && self.answered(&objects::RATED_TORQUE).access != Access::ReadWrite => {
                    row.with(Verdict::WorksWith, Remedy::RatedTorque(found))
                }
                _ => self.to_write(row, &objects::RATED_TORQUE, wanted),
            },
            Answer::NotANumber | Answer::OtherType(_) | Answer::Refused(_) => {
                row.with(Verdict::WorksWith, Remedy::TorqueStated)
            }
        }
    }

    /// 6072h and 6073h are fences of the drive's own: shown beside the robot file's.
    pub(super) fn torque_limits(&mut self) -> Finding {
        let ceiling = i64::from(self.drive.torque_ceiling.per_mille());
        let (torque, current) = (&objects::MAXIMUM_TORQUE, &objects::MAXIMUM_CURRENT);
        let object = if self.answer(torque).is_there() { torque } else { current };
        let row = self.row(Question::TorqueLimits, object, Wanted::Words("per mille, above limits.torque_nm"));
        match row.found {
            Answer::Number(limit) if limit < ceiling => {
                row.noting("the drive cuts torque below the robot file's limit")
            }
            Answer::Absent => row.noting("nothing but the robot file limits torque"),
            _ => row,
        }
    }

    /// 6091h must be 1:1; 6092h 1:1, or as many units in a revolution as the encoder has counts.
    pub(super) fn position_units(&mut self) -> Finding {
        let counts = i64::from(self.drive.counts_per_revolution);
        let gear = [&objects::GEAR_MOTOR_REVOLUTIONS, &objects::GEAR_SHAFT_REVOLUTIONS];
        let feed = [&objects::FEED, &objects::FEED_SHAFT_REVOLUTIONS];
        let neutral = Wanted::Words("1 to 1; the gear belongs into the robot file");
        match self.ratio(gear) {
            Ratio::None | Ratio::Of(1, 1) => {}
            Ratio::Unstated => return self.row(Question::PositionUnits, gear[0], neutral).noting(READ_AT_START),
            Ratio::Of(motor, shaft) if motor == shaft && motor > 0 => {}
            Ratio::Of(..) => return self.neutral(gear, neutral),
        }
        let wanted = Wanted::Words("1 to 1, or as many as counts per revolution");
        let row = self.row(Question::PositionUnits, feed[0], wanted);
        match self.ratio(feed) {
            Ratio::None => self.row(Question::PositionUnits, gear[0], neutral),
            Ratio::Of(units, turns) if units == turns && units > 0 => row,
            Ratio::Of(units, turns) if counts.checked_mul(turns) == Some(units) => row,
            Ratio::Unstated => row.noting(READ_AT_START),
            Ratio::Of(..) => self.neutral(feed, wanted),
        }
    }

    fn ratio(&self, [over, under]: [&Object; 2]) -> Ratio {
        match (self.answer(over), self.answer(under)) {
            (Answer::Number(over), Answer::Number(under)) => Ratio::Of(over, under),
            (Answer::Number(over), Answer::Absent) => Ratio::Of(over, 1),
            (Answer::Unstated, _) | (_, Answer::Unstated) => Ratio::Unstated,
            _ => Ratio::None,
        }
    }

    /// The remedy that makes a ratio 1 to 1, one of its numbers at a time.
    fn neutral(&self, ratio: [&Object; 2], wanted: Wanted) -> Finding {
        let [over, _] = ratio;
        let object = ratio.into_iter().find(|object| self.number(object) != Some(1)).unwrap_or(over);
        self.to_write(self.row(Question::PositionUnits, object, wanted), object, 1)
    }

    pub(super) fn polarity(&mut self) -> Finding {
        let row = self.row(Question::Polarity, &objects::POLARITY, Wanted::Words("0; encoder.direction says the sign"));
        match row.found {
            Answer::Number(0) | Answer::Absent => row,
            Answer::Unstated => row.noting(READ_AT_START),
            _ => self.to_write(row, &objects::POLARITY, 0),
        }
    }
}

/// A number of counts that a robot file can state.
fn counts_per_revolution(number: i64) -> Option<u32> {
    u32::try_from(number).ok().filter(|counts| CountsPerRevolution::RANGE.contains(counts))
}

/// A ratio of two objects.
enum Ratio {
    /// The drive has none.
    None,
    /// Only the drive knows it.
    Unstated,
    /// This one.
    Of(i64, i64),
}

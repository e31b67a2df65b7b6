//! What is asked of a drive beside its motion: what a run watches, and the mark that tells of a loss of power.

use super::finding::{Finding, Question, Remedy, Verdict, Wanted};
use super::planner::Planner;
use crate::drive::objects;
use crate::drive::power_marker::conflict;
use crate::drive::readings::Quantity;
use crate::drive::survey::{Answer, SourceKind};
use canopen_rs::{Address, DataType};

impl Planner<'_> {
    /// The objects that the robot file reads in a run: each there, readable, and of the type that is said.
    pub(super) fn readings(&mut self) -> Finding {
        let mut worst: Option<Finding> = None;
        for (reading, quantity) in self.drive.readings.iter().zip(Quantity::ALL) {
            let Some(reading) = reading else { continue };
            let remedy = match quantity {
                Quantity::SupplyVoltage => {
                    "drive.supply_voltage_v.object as the drive has it, or leave drive.supply_voltage_v out"
                }
                Quantity::Temperature => {
                    "drive.temperature_c.object as the drive has it, or leave drive.temperature_c out"
                }
            };
            let wanted = Wanted::Type(reading.data_type, "readable");
            let row = self.of_type(Question::Readings, reading.object, reading.data_type, wanted);
            let row = match row.found {
                _ if !self.survey.at(reading.object).access.may_read() => {
                    row.with(Verdict::Cannot, Remedy::RobotFile(remedy))
                }
                Answer::Number(_) | Answer::Unstated => row,
                _ => row.with(Verdict::Cannot, Remedy::RobotFile(remedy)),
            };
            worst = worst.filter(|worst| worst.verdict >= row.verdict).or(Some(row));
        }
        worst.unwrap_or_else(|| {
            self.row(Question::Readings, &objects::DC_LINK_VOLTAGE, Wanted::Words("anything: nothing is watched"))
        })
    }

    /// The object of the mark: nobody uses it, it can be read, can be written with the mark's value, and has another at power-up.
    pub(super) fn power_marker(&mut self) -> Finding {
        const REMEDY: &str =
            "another encoder.power_marker: an object that can be written and that the drive forgets with its power";
        let Some(marker) = self.drive.power_marker else {
            let wanted = Wanted::Words("anything: encoder.power_marker names none");
            return self.row(Question::PowerMarker, &objects::STATUSWORD, wanted);
        };
        let data_type = marker.value.data_type();
        let wanted = Wanted::Type(data_type, "readable and writable with the mark");
        let row = self.of_type(Question::PowerMarker, marker.address, data_type, wanted);
        let known = self.survey.at(marker.address);
        let can_hold = matches!(row.found, Answer::Number(_) | Answer::Unstated)
            && known.access.may_read()
            && Answer::of(marker.value).number().is_some_and(|value| known.may_become(value));
        if let Some(wanted) = conflict(self.drive) {
            return Finding { wanted: Wanted::Words(wanted), ..row }.with(Verdict::Cannot, Remedy::RobotFile(REMEDY));
        }
        if !can_hold {
            return row.with(Verdict::Cannot, Remedy::RobotFile(REMEDY));
        }
        // A drive on the bus may have its mark already.
        if self.survey.source() == SourceKind::DictionaryFile && row.found == Answer::of(marker.value) {
            let wanted = Wanted::Words("another value at power-up than the mark: a loss of power would not be seen");
            return Finding { wanted, ..row }
                .with(Verdict::Cannot, Remedy::RobotFile("another encoder.power_marker.value"));
        }
        row
    }

    /// The row of an object that is to have this type: what was found is another type where one is stated.
    fn of_type(&self, question: Question, object: Address, data_type: DataType, wanted: Wanted) -> Finding {
        let known = self.survey.at(object);
        let found = match known.data_type {
            Some(stated) if stated != data_type => Answer::OtherType(stated),
            _ => known.answer,
        };
        Finding { question, object, found, wanted, remedy: Remedy::None, verdict: Verdict::Works }
    }
}

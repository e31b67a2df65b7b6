//! The PDOs: those of the cycle mapped and switched on, every other switched off.

use super::finding::{Finding, Question, Remedy, Verdict, Wanted};
use super::planner::{Fit, Planner, fit};
use crate::drive::objects::{self, Object};
use crate::drive::pdo_objects::{PdoKind, PdoNumber};
use crate::drive::survey::{
    Access, Answer, PDO_EXTENDED, PDO_IDENTIFIER, PDO_NO_REMOTE_FRAME, PDO_OFF, PdoRecord, Reach, Room,
};
use crate::drive::wire;
use crate::drive::wishes::{PdoChannel, Setting};
use canopen_rs::{MappingEntry, Value};

/// What a PDO of the cycle has to be.
struct Wish<'m> {
    question: Question,
    kind: PdoKind,
    channel: PdoChannel,
    mapping: &'m [u32],
    transmission: u8,
}

impl Planner<'_> {
    pub(super) fn command(&mut self) -> Finding {
        let channel = self.drive.pdos.command;
        let mapping = wire::RPDO1_MAPPING.map(MappingEntry::to_u32);
        let predefined = self.drive.torque_applies.transmission_type();
        let transmission = self.drive.command_transmission.unwrap_or(predefined);
        self.pdo(&Wish {
            question: Question::Command,
            kind: PdoKind::Receive,
            channel,
            mapping: &mapping,
            transmission,
        })
    }

    pub(super) fn feedback(&mut self) -> Finding {
        let channel = self.drive.pdos.feedback;
        let mapping = wire::TPDO1_MAPPING.map(MappingEntry::to_u32);
        self.pdo(&Wish {
            question: Question::Feedback,
            kind: PdoKind::Transmit,
            channel,
            mapping: &mapping,
            transmission: wire::TPDO1_TRANSMISSION.to_byte(),
        })
    }

    pub(super) fn torque_feedback(&mut self) -> Finding {
        let Some(channel) = self.drive.pdos.torque_feedback else {
            return self.row(Question::TorqueFeedback, &objects::TORQUE_ACTUAL, Wanted::Words("anything: not wanted"));
        };
        let mapping = [wire::TORQUE_FEEDBACK_MAPPING.to_u32()];
        if !self.answer(&objects::TORQUE_ACTUAL).is_there() {
            let row = self.row(Question::TorqueFeedback, &objects::TORQUE_ACTUAL, Wanted::Words("there"));
            return row.with(Verdict::Cannot, Remedy::RobotFile("leave drive.pdo.torque_tpdo out"));
        }
        self.pdo(&Wish {
            question: Question::TorqueFeedback,
            kind: PdoKind::Transmit,
            channel,
            mapping: &mapping,
            transmission: wire::TPDO1_TRANSMISSION.to_byte(),
        })
    }

    /// Plans a PDO of the cycle. A mapping that is right is left alone, so that fixed ones do.
    fn pdo(&mut self, wish: &Wish<'_>) -> Finding {
        let number = wish.channel.number;
        let identifier = wish.kind.identifier(number);
        let Some(record) = self.survey.pdo(wish.kind, number).copied() else {
            let row = self.row(wish.question, &identifier, Wanted::Words("there"));
            return self.helped(wish, row, "another drive, or another number in drive.pdo");
        };
        let mapped = record.carries(wish.mapping);
        if !mapped && let Some(row) = self.mapping_refused(wish, &record) {
            return row;
        }
        let transmission = fit(record.transmission, wish.transmission.into());
        if !transmission.is_met() {
            let wanted = Wanted::Number(wish.transmission.into());
            let row = self.row(wish.question, &wish.kind.transmission(number), wanted);
            let row = Finding { found: record.transmission.answer, ..row };
            return match other_transmission(wish, &record) {
                Some(remedy) => row.with(Verdict::WorksWith, remedy),
                None => self.helped(wish, row, another_number(wish.question)),
            };
        }
        let wanted = i64::from(wish.channel.identifier.as_raw());
        let row = self.row(wish.question, &identifier, Wanted::Number(wanted));
        let row = Finding { found: record.identifier.answer, ..row };
        let is_on = is_on_as(record.identifier.answer, wanted);
        if mapped && is_on && transmission == Fit::AsWanted {
            return row;
        }
        if !record.identifier.access.may_write() {
            return row.refusing(another_number(wish.question));
        }
        self.write_pdo(wish, &record, mapped);
        row
    }

    /// The row that says why a mapping cannot be made what is wanted; `None` if it can.
    fn mapping_refused(&self, wish: &Wish<'_>, record: &PdoRecord) -> Option<Finding> {
        if can_carry(record, wish.mapping) {
            return None;
        }
        let object = wish.kind.mapped_objects(record.number);
        let wanted = Wanted::Words("what the cycle carries, or a mapping that can be changed");
        let row = Finding { found: record.count.answer, ..self.row(wish.question, &object, wanted) };
        Some(self.helped(wish, row, "another drive: no PDO of it carries this"))
    }

    /// The row with the number of another PDO as remedy; refused with `words` if there is none.
    fn helped(&self, wish: &Wish<'_>, row: Finding, words: &'static str) -> Finding {
        match self.other_pdo(wish) {
            Some(number) if wish.question != Question::TorqueFeedback => {
                row.with(Verdict::WorksWith, Remedy::PdoNumber(wish.kind, number))
            }
            _ => row.refusing(words),
        }
    }

    /// Another PDO, used for nothing else, that carries what is wanted; else one that can be made to.
    fn other_pdo(&self, wish: &Wish<'_>) -> Option<PdoNumber> {
        let identifier = i64::from(wish.channel.identifier.as_raw());
        let is_fit = |pdo: &&PdoRecord| {
            let can_be_on = pdo.identifier.access.may_write() || is_on_as(pdo.identifier.answer, identifier);
            let has_type = fit(pdo.transmission, wish.transmission.into()).is_met();
            can_be_on && has_type && !self.drive.pdos.uses(wish.kind, pdo.number)
        };
        let pdos = || self.survey.pdos(wish.kind).iter().filter(is_fit);
        let carries = pdos().find(|pdo| pdo.carries(wish.mapping));
        carries.or_else(|| pdos().find(|pdo| can_carry(pdo, wish.mapping))).map(|pdo| pdo.number)
    }

    /// The standard's order (CiA 301): off, count 0, objects, count, type, on. Identifiers change only while the PDO is
    /// off, and what a drive has in bit 30 stays.
    fn write_pdo(&mut self, wish: &Wish<'_>, record: &PdoRecord, mapped: bool) {
        let (kind, number) = (wish.kind, record.number);
        let identifier = kind.identifier(number);
        let found = record.identifier.answer.number();
        let kept = found.unwrap_or_default() & PDO_NO_REMOTE_FRAME;
        let wanted = i64::from(wish.channel.identifier.as_raw()) | kept;
        if !record.is_off() {
            self.write_identifier(&identifier, found.unwrap_or(wanted) | PDO_OFF);
        }
        if !mapped {
            self.write_mapping(wish, record);
        }
        let known = record.transmission;
        if fit(known, wish.transmission.into()) != Fit::AsWanted {
            self.write_number(&kind.transmission(number), wish.transmission.into());
        }
        self.write_identifier(&identifier, wanted);
    }

    fn write_mapping(&mut self, wish: &Wish<'_>, record: &PdoRecord) {
        let (kind, number) = (wish.kind, record.number);
        let count = kind.mapped_objects(number);
        if record.count.answer != Answer::Number(0) {
            self.write_number(&count, 0);
        }
        for ((subindex, entry), found) in (1_u8..).zip(wish.mapping).zip(&record.entries) {
            if *found != Answer::Number((*entry).into()) {
                self.write_number(&kind.mapped_object(number, subindex), (*entry).into());
            }
        }
        self.write_number(&count, i64::try_from(wish.mapping.len()).unwrap_or_default());
    }

    /// Switches off every PDO that is not used.
    pub(super) fn other_pdos(&mut self) -> Finding {
        let survey = self.survey;
        if let Room::Exceeded(kind, number) = survey.room() {
            return self.row(Question::OtherPdos, &kind.identifier(number), Wanted::Words("off (bit 31)")).refusing(
                "more PDOs are on than can be looked at: switch them off with the maker's tool and store that",
            );
        }
        let object = PdoKind::Transmit.identifier(PdoNumber::SECOND);
        let found =
            survey.pdo(PdoKind::Transmit, PdoNumber::SECOND).map_or(Answer::Absent, |pdo| pdo.identifier.answer);
        let mut row = Finding { found, ..self.row(Question::OtherPdos, &object, Wanted::Words("off (bit 31)")) };
        for kind in [PdoKind::Transmit, PdoKind::Receive] {
            for record in survey.pdos(kind) {
                if record.is_off() || self.drive.pdos.uses(kind, record.number) {
                    continue;
                }
                let object = kind.identifier(record.number);
                if record.reach == Reach::BehindGap && record.identifier.access.may_write() {
                    if !self.is_switched_off_by_file(&object) {
                        let off = record.identifier.answer.number().unwrap_or_default() | PDO_OFF;
                        let off = u32::try_from(off).unwrap_or(u32::MAX);
                        let remedy = Remedy::Write(Setting::new(object.address(), Value::Unsigned32(off)));
                        row = Finding { object: object.address(), found: record.identifier.answer, ..row }
                            .with(Verdict::WorksWith, remedy);
                    }
                } else if record.identifier.access.may_write() {
                    self.write_identifier(&object, record.identifier.answer.number().unwrap_or_default() | PDO_OFF);
                } else {
                    row = Finding { object: object.address(), found: record.identifier.answer, ..row }
                        .with(Verdict::WorksWith, Remedy::KeepPdo(kind, record.number));
                }
            }
        }
        row
    }
}

impl Planner<'_> {
    /// True if `drive.writes` switches off the PDO with this identifier: one that a start does not look for.
    fn is_switched_off_by_file(&self, identifier: &Object) -> bool {
        let drive = self.drive;
        let mut settings = drive.settings.iter().chain(&drive.later_settings);
        settings.any(|setting| {
            let value = Answer::of(setting.value).number();
            setting.address == identifier.address() && value.is_some_and(|value| value & PDO_OFF != 0)
        })
    }
}

/// The transmission type that the drive's RPDO of commands has, if a command can have it: it acts when it comes (254, 255), or at
/// the next SYNC (0, 1).
fn other_transmission(wish: &Wish<'_>, record: &PdoRecord) -> Option<Remedy> {
    let found = u8::try_from(record.transmission.answer.number()?).ok()?;
    let is_fit = wish.question == Question::Command && matches!(found, 0 | 1 | 254 | 255);
    is_fit.then_some(Remedy::CommandTransmission(found))
}

/// False if it is known that `mapping` cannot be put into a PDO.
fn can_carry(record: &PdoRecord, mapping: &[u32]) -> bool {
    let length = i64::try_from(mapping.len()).unwrap_or(i64::MAX);
    record.count.answer.is_there()
        && record.count.access.may_write()
        && record.entry_access != Access::ReadOnly
        && record.count.most.is_none_or(|most| most >= length)
}

/// The key that names another PDO.
const fn another_number(question: Question) -> &'static str {
    match question {
        Question::Command => "another drive, or another number in drive.pdo.rpdo",
        Question::Feedback => "another drive, or another number in drive.pdo.tpdo",
        _ => "another number in drive.pdo.torque_tpdo, or leave it out",
    }
}

/// True if a PDO with this identifier is on, under `wanted`.
fn is_on_as(found: Answer, wanted: i64) -> bool {
    found.number().is_some_and(|found| found & (PDO_OFF | PDO_EXTENDED | PDO_IDENTIFIER) == wanted)
}

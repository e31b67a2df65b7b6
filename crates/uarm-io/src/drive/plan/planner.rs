//! What all rows of a plan share: what the drive will say once the robot file's objects are written, and what is to be
//! written after them.

use super::finding::{Finding, Question, Remedy, Verdict, Wanted, value_of};
use crate::drive::objects::Object;
use crate::drive::survey::{Answer, Answered, Survey};
use crate::drive::wishes::{DriveConfiguration, MAX_SETTINGS, Protocol, Setting};

/// Objects that a plan can write: a robot file's before and after, and those of the protocol, of which there are at most
/// one for each PDO that is switched off, seven for each that is used, five for homing, and twelve others.
pub const MOST_PLANNED: usize = 2 * MAX_SETTINGS + 2 * crate::drive::survey::MOST_PDOS + 3 * 7 + 5 + 12;

/// What is written, in this order.
pub type PlannedSettings = heapless::Vec<Setting, MOST_PLANNED>;

/// A plan in the making.
pub(super) struct Planner<'a> {
    pub(super) survey: &'a Survey,
    pub(super) drive: &'a DriveConfiguration,
    pub(super) protocol: &'a Protocol,
    pub(super) settings: PlannedSettings,
}

/// What came of wanting a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fit {
    /// It is there already.
    AsWanted,
    /// It will be written.
    Written,
    /// There is no such object.
    Absent,
    /// The object cannot take it.
    CannotBeWritten,
}

impl Fit {
    /// True if the value is there in the end.
    pub(super) const fn is_met(self) -> bool {
        matches!(self, Self::AsWanted | Self::Written)
    }
}

impl Planner<'_> {
    /// What is known of `object` after the robot file's objects are written.
    pub(super) fn answered(&self, object: &Object) -> Answered {
        let found = self.survey.get(object);
        let written = self.drive.settings.iter().rev().find(|setting| setting.address == object.address());
        match written {
            Some(setting) if takes(found) => Answered { answer: Answer::of(setting.value), ..found },
            _ => found,
        }
    }

    /// What the robot file writes into it after the protocol's objects, in the end.
    pub(super) fn written_later(&self, object: &Object) -> Option<Answer> {
        let is_it = |setting: &&Setting| setting.address == object.address();
        let written = self.drive.later_settings.iter().rev().find(is_it).map(|setting| Answer::of(setting.value));
        written.filter(|_| takes(self.survey.get(object)))
    }

    /// Its answer.
    pub(super) fn answer(&self, object: &Object) -> Answer {
        self.answered(object).answer
    }

    /// Its number.
    pub(super) fn number(&self, object: &Object) -> Option<i64> {
        self.answer(object).number()
    }

    /// Plans to write a setting.
    pub(super) fn push(&mut self, setting: Setting) {
        // There is room: see `MOST_PLANNED`.
        let _ = self.settings.push(setting);
    }

    /// Plans `wanted` in `object`, unless it is there.
    pub(super) fn want(&mut self, object: &Object, wanted: i64) -> Fit {
        let found = self.answered(object);
        let fit = fit(found, wanted);
        if fit == Fit::Written {
            self.write_number(object, wanted);
        }
        fit
    }

    /// Plans `number` in `object`, whatever is there.
    pub(super) fn write_number(&mut self, object: &Object, number: i64) {
        if let Some(setting) = setting(object, number) {
            self.push(setting);
        }
    }

    /// Plans an identifier in `object`.
    pub(super) fn write_identifier(&mut self, object: &Object, identifier: i64) {
        if let Ok(identifier) = u32::try_from(identifier) {
            self.push(Setting::identifier(object, identifier));
        }
    }

    /// The row for `object`.
    pub(super) fn row(&self, question: Question, object: &Object, wanted: Wanted) -> Finding {
        Finding {
            question,
            object: object.address(),
            found: self.answer(object),
            wanted,
            remedy: Remedy::None,
            verdict: Verdict::Works,
        }
    }
}

/// False if it is known that nothing can be written into an object of which this is known.
fn takes(found: Answered) -> bool {
    found.answer.is_there() && found.access.may_write()
}

/// What comes of wanting a number in an object of which this is known.
pub(super) fn fit(found: Answered, wanted: i64) -> Fit {
    match found.answer {
        Answer::Absent => Fit::Absent,
        Answer::Number(value) if value == wanted => Fit::AsWanted,
        _ if found.may_become(wanted) => Fit::Written,
        _ => Fit::CannotBeWritten,
    }
}

impl Finding {
    /// The row with a verdict and a remedy.
    pub(super) fn with(self, verdict: Verdict, remedy: Remedy) -> Self {
        Self { verdict, remedy, ..self }
    }

    /// The row of something that works, and about which something is to be known.
    pub(super) fn noting(self, words: &'static str) -> Self {
        self.with(Verdict::WorksWith, Remedy::Note(words))
    }

    /// The row of something that cannot work.
    pub(super) fn refusing(self, words: &'static str) -> Self {
        self.with(Verdict::Cannot, Remedy::Outside(words))
    }
}

/// `object` with `number`, which fits its type; `None` if it does not.
pub(super) fn setting(object: &Object, number: i64) -> Option<Setting> {
    value_of(object.data_type, number).map(|value| Setting::of(object, value))
}

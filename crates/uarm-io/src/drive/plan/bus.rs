//! SYNC, period, emergencies, and what happens when the master is gone.

use super::finding::{Finding, Question, Remedy, Verdict, Wanted};
use super::planner::{Fit, Planner, fit, setting};
use crate::drive::objects;
use crate::drive::pdo_objects::PdoKind;
use crate::drive::survey::{Answer, Answered, PDO_IDENTIFIER, PDO_OFF};
use crate::drive::wire::{self, Channel};
use crate::drive::wishes::{AbortOption, SyncPayload, Watchdog};
use core::time::Duration;

/// Bit 30 of 1005h: the device itself sends SYNCs.
const SENDS_SYNC: i64 = 1 << 30;
const READ_AT_START: &str = "it is read at start, and must then be so";
/// A watchdog that the robot file would switch off again.
const UNDONE: &str = "leave it out of the drive.writes that come after: they would undo the watchdog";
/// A 6007h that says that the drive does nothing, and cannot be written.
const UNCHANGEABLE: &str = "another drive; or, where it was tried with the arm supported, drive.without_6007h says in your own words \
                            how it is known that it brakes without its master";
/// 6007h: the loss of the master is a fault.
const LOSS_IS_FAULT: i64 = 1;

impl Planner<'_> {
    pub(super) fn sync(&mut self) -> Finding {
        let identifier = i64::from(Channel::Sync.identifier().as_raw());
        let object = &objects::SYNC_IDENTIFIER;
        let row = self.row(Question::Sync, object, Wanted::Number(identifier));
        let as_wanted =
            matches!(row.found, Answer::Number(found) if found & (SENDS_SYNC | PDO_IDENTIFIER) == identifier);
        // Without the object the identifier is that of the predefined connection set.
        if !as_wanted && row.found.is_there() && !self.want(object, identifier).is_met() {
            return row.refusing("another drive: its SYNC has another identifier");
        }
        self.sync_counter()
    }

    fn sync_counter(&mut self) -> Finding {
        let object = &objects::SYNC_COUNTER_OVERFLOW;
        let wanted = i64::from(self.protocol.sync_payload.overflow());
        let row = self.row(Question::Sync, object, Wanted::Number(wanted));
        match (self.want(object, wanted), self.protocol.sync_payload) {
            (Fit::AsWanted | Fit::Written, _) => row,
            (Fit::Absent, SyncPayload::Empty) => {
                Finding { wanted: Wanted::Words("absent or 0: the SYNC carries no counter"), ..row }
            }
            (Fit::CannotBeWritten, SyncPayload::Counter) => {
                row.with(Verdict::Cannot, Remedy::RobotFile("[bus] sync_counter = \"off\""))
            }
            (_, SyncPayload::Counter) => row.with(Verdict::WorksWith, Remedy::SyncWithoutCounter),
            (_, SyncPayload::Empty) if row.found == Answer::Number(SyncPayload::Counter.overflow().into()) => {
                row.with(Verdict::Cannot, Remedy::RobotFile("[bus] sync_counter = \"on\""))
            }
            (_, SyncPayload::Empty) => row.refusing("another drive: its SYNC counter cannot be switched off"),
        }
    }

    /// 60C2h: in the exponent that the drive has, if it can hold the period: that one may be fixed, which a drive tells only
    /// when it is written to. Else whole milliseconds as (n, −3), which all makers take, and other exponents where
    /// milliseconds cannot hold the period. What is right already stays.
    pub(super) fn period(&mut self) -> Finding {
        let (value, exponent) = (&objects::INTERPOLATION_TIME_VALUE, &objects::INTERPOLATION_TIME_EXPONENT);
        let period = self.protocol.period;
        let found = (self.answered(value), self.answered(exponent));
        if let (Some(found_value), Some(found_exponent)) = (found.0.answer.number(), found.1.answer.number())
            && is_time(found_value, found_exponent, period)
        {
            return self.row(Question::Period, value, Wanted::Number(found_value));
        }
        if !found.0.answer.is_there() {
            let row = self.row(Question::Period, value, Wanted::Words("the period, or absent"));
            return row.noting("the drive is not told the period");
        }
        let as_found = |time: &(u8, i8)| found.1.answer == Answer::Number(time.1.into());
        for (wanted_value, wanted_exponent) in
            interpolation_times(period).filter(as_found).chain(interpolation_times(period))
        {
            let (wanted_value, wanted_exponent) = (i64::from(wanted_value), i64::from(wanted_exponent));
            // An exponent that is absent is −3, whole milliseconds.
            let exponent_fits = match found.1.answer {
                Answer::Absent => wanted_exponent == MILLISECONDS.into(),
                _ => fit(found.1, wanted_exponent).is_met(),
            };
            if exponent_fits && fit(found.0, wanted_value).is_met() {
                let row = self.row(Question::Period, value, Wanted::Number(wanted_value));
                self.want(value, wanted_value);
                self.want(exponent, wanted_exponent);
                return row;
            }
        }
        let row =
            self.row(Question::Period, value, Wanted::Words("control.period_us, in whole milliseconds as a rule"));
        let fixed = |time: Answered| time.answer.number().filter(|_| !time.access.may_write());
        // A drive does not tell whether its exponent is fixed, too: it has the one with which the period is one of a loop.
        let exponents = fixed(found.1).map_or_else(
            || [found.1.answer.number().unwrap_or(MILLISECONDS.into()), MILLISECONDS.into()],
            |exponent| [exponent; 2],
        );
        let of_a_loop = |value| {
            let mut periods = exponents.into_iter().filter_map(|exponent| microseconds(value, exponent));
            periods.find(|period| *period < LONGEST_OF_A_LOOP)
        };
        match fixed(found.0).and_then(of_a_loop) {
            Some(microseconds) => row.with(Verdict::WorksWith, Remedy::Period(microseconds)),
            None => row.with(Verdict::Cannot, Remedy::RobotFile("a control.period_us that the drive takes")),
        }
    }

    pub(super) fn emergency(&mut self) -> Finding {
        let object = &objects::EMERGENCY_IDENTIFIER;
        let wanted = i64::from(Channel::Emergency(self.drive.node).identifier().as_raw());
        let row = self.row(Question::Emergency, object, Wanted::Number(wanted));
        const UNHEARD: &str = "its emergencies are not heard";
        match row.found {
            Answer::Number(found) if found & (PDO_OFF | PDO_IDENTIFIER) == wanted => row,
            Answer::Absent => row.noting("its emergencies are heard if it has the predefined identifier"),
            Answer::Unstated => row.noting("it is read at start"),
            Answer::Number(found) if self.answered(object).access.may_write() => {
                // As a PDO's, the identifier changes only while it is off.
                if found & PDO_OFF == 0 {
                    self.write_identifier(object, found | PDO_OFF);
                }
                self.write_identifier(object, wanted);
                row
            }
            _ => row.noting(UNHEARD),
        }
    }

    /// The last line of defence: the heartbeat of the master, or the timeout of its commands.
    pub(super) fn watchdog(&mut self) -> Finding {
        let consumer = &objects::CONSUMER_HEARTBEAT_TIME;
        let entry = wire::consumer_heartbeat_entry(self.protocol.heartbeats.master_timeout_milliseconds());
        let row = self.row(Question::Watchdog, consumer, Wanted::Number(entry.into()));
        if let Some(found) = self.written_later(consumer).filter(|later| *later != Answer::Number(entry.into())) {
            return Finding { found, ..row }.refusing(UNDONE);
        }
        // The dictionary of one maker limits the entry to 16 bits, which holds no node: the drive itself decides.
        let found = self.answered(consumer);
        let heartbeat = if found.answer == Answer::Number(entry.into()) {
            Fit::AsWanted
        } else if found.answer.is_there() && found.access.may_write() {
            self.write_number(consumer, entry.into());
            Fit::Written
        } else {
            Fit::CannotBeWritten
        };
        match self.drive.watchdog {
            Watchdog::RpdoTimeout { milliseconds, .. } => self.rpdo_timeout(milliseconds),
            Watchdog::Heartbeat if heartbeat.is_met() => row,
            Watchdog::Heartbeat if self.has_rpdo_timeout() => row.with(Verdict::WorksWith, Remedy::RpdoTimeout),
            Watchdog::Heartbeat => row.refusing("another drive: nothing makes it brake when its master is gone"),
        }
    }

    fn has_rpdo_timeout(&self) -> bool {
        let command = self.survey.pdo(PdoKind::Receive, self.drive.pdos.command.number);
        command.is_some_and(|pdo| pdo.event_timer.answer.is_there() && pdo.event_timer.access.may_write())
    }

    fn rpdo_timeout(&mut self, milliseconds: u16) -> Finding {
        let number = self.drive.pdos.command.number;
        let object = PdoKind::Receive.event_timer(number);
        let wanted = i64::from(milliseconds);
        let found = self.survey.pdo(PdoKind::Receive, number).map(|pdo| pdo.event_timer).unwrap_or_default();
        let row = Finding { found: found.answer, ..self.row(Question::Watchdog, &object, Wanted::Number(wanted)) };
        if let Some(found) = self.written_later(&object).filter(|later| *later != Answer::Number(wanted)) {
            return Finding { found, ..row }.refusing(UNDONE);
        }
        match fit(found, wanted) {
            Fit::AsWanted => row,
            Fit::Written => {
                self.write_number(&object, wanted);
                row
            }
            Fit::Absent | Fit::CannotBeWritten => row.refusing("drive.watchdog = \"heartbeat\", or another drive"),
        }
    }

    /// 6007h, which says what the loss of the heartbeat does.
    pub(super) fn loss_reaction(&mut self) -> Finding {
        let object = &objects::ABORT_CONNECTION_OPTION;
        let row = self.row(Question::LossReaction, object, Wanted::Words("1 fault, 2 disable voltage or 3 quick stop"));
        // What is written last stands.
        let row = Finding { found: self.written_later(object).unwrap_or(row.found), ..row };
        if self.drive.abort_option == AbortOption::Explained || self.drive.watchdog != Watchdog::Heartbeat {
            return match row.found {
                Answer::Number(1..=3) => row,
                _ => row.noting("it is not what the robot file relies on"),
            };
        }
        match row.found {
            Answer::Number(1..=3) => row,
            Answer::Number(value) if value < 0 => row.noting("a code of the maker's: look it up"),
            Answer::Unstated => row.noting(READ_AT_START),
            Answer::Number(_) => match setting(object, LOSS_IS_FAULT) {
                Some(setting) if self.answered(object).access.may_write() => {
                    row.with(Verdict::WorksWith, Remedy::Write(setting))
                }
                // That it brakes all the same is for who has tried it to say, in words that nobody can propose.
                _ => row.with(Verdict::Cannot, Remedy::RobotFile(UNCHANGEABLE)),
            },
            _ => row.with(Verdict::WorksWith, Remedy::ExplainAbortOption),
        }
    }
}

const MILLISECONDS: i8 = -3;
/// No loop that sends torques is as slow, µs.
const LONGEST_OF_A_LOOP: u32 = 1_000_000;

/// `period` as value · 10^exponent s, in the order of preference: milliseconds first, then the largest exponent that is
/// exact, and those below it.
pub fn interpolation_times(period: Duration) -> impl Iterator<Item = (u8, i8)> {
    const EXPONENTS: [i8; 10] = [MILLISECONDS, 0, -1, -2, -4, -5, -6, -7, -8, -9];
    EXPONENTS.into_iter().filter_map(move |exponent| {
        let value = u128::from(nanoseconds(exponent)?);
        let count = period.as_nanos().checked_div(value)?;
        let count = u8::try_from(count).ok().filter(|count| *count > 0)?;
        (u128::from(count) * value == period.as_nanos()).then_some((count, exponent))
    })
}

/// 10^exponent s in ns, for exponents −9 … 0.
fn nanoseconds(exponent: i8) -> Option<u64> {
    10_u64.checked_pow(u32::try_from(exponent.checked_add(9)?).ok()?)
}

/// True if value · 10^exponent s is `period`.
fn is_time(value: i64, exponent: i64, period: Duration) -> bool {
    time(value, exponent) == Some(period)
}

/// value · 10^exponent s, for exponents −9 … 0.
fn time(value: i64, exponent: i64) -> Option<Duration> {
    let unit = i8::try_from(exponent).ok().filter(|exponent| *exponent <= 0).and_then(nanoseconds)?;
    u64::try_from(value).ok()?.checked_mul(unit).map(Duration::from_nanos)
}

/// value · 10^exponent s in whole µs, as `control.period_us` counts it.
fn microseconds(value: i64, exponent: i64) -> Option<u32> {
    let time = time(value, exponent).filter(|time| !time.is_zero() && time.subsec_nanos() % 1000 == 0)?;
    u32::try_from(time.as_micros()).ok()
}

//! What the drive is: profile, identity, mode, and the objects of the cycle.

use super::finding::{Finding, Question, Remedy, Verdict, Wanted};
use super::planner::{Fit, Planner};
use crate::drive::objects::{self, Object};
use crate::drive::pdo_objects::PdoKind;
use crate::drive::survey::Answer;
use crate::drive::wishes::Operation;
use canopen_rs::DataType;

/// 1000h: the low word is the device profile.
const PROFILE_MASK: i64 = 0xFFFF;
const READ_AT_START: &str = "it is read at start";

/// True if a PDO carries a whole number of this type in as many bits as one of `wanted`; makers mistake signs.
fn is_as_wide(stated: DataType, wanted: DataType) -> bool {
    stated != DataType::Real32 && stated.fixed_size() == wanted.fixed_size()
}

impl Planner<'_> {
    pub(super) fn device_type(&mut self) -> Finding {
        let row = self.row(Question::DeviceType, &objects::DEVICE_TYPE, Wanted::Words("low word 402 (0192h)"));
        match row.found {
            Answer::Number(value) if value & PROFILE_MASK == i64::from(objects::DEVICE_PROFILE_CIA402) => row,
            Answer::Unstated => row.noting(READ_AT_START),
            _ => row.refusing("another drive"),
        }
    }

    pub(super) fn identity(&mut self) -> Finding {
        let pinned = self.drive.identity;
        let numbers = [
            (&objects::VENDOR_ID, pinned.vendor),
            (&objects::PRODUCT_CODE, pinned.product),
            (&objects::SERIAL_NUMBER, pinned.serial),
        ];
        let mut unknown = None;
        for (object, number) in numbers {
            let Some(wanted) = number.map(i64::from) else { continue };
            let row = self.row(Question::Identity, object, Wanted::Number(wanted));
            match row.found {
                Answer::Number(found) if found == wanted => {}
                // A dictionary file knows no serial number.
                Answer::Unstated => unknown = Some(row.noting(READ_AT_START)),
                _ => {
                    return row.refusing(
                        "the drive that drive.identity or the joint's profile names; or its numbers in drive.identity",
                    );
                }
            }
        }
        let recorded = self.row(Question::Identity, &objects::VENDOR_ID, Wanted::Words("anything; it is recorded"));
        unknown.unwrap_or(recorded)
    }

    pub(super) fn mode(&mut self) -> Finding {
        let operation = self.drive.operation;
        let wanted = i64::from(operation.mode());
        let (set, otherwise) = match operation {
            Operation::CyclicTorque => {
                ("bit 9 set", "another drive, or another firmware: profile torque (4) has ramps")
            }
            Operation::Homing(_) => ("bit 5 set", "a pose at marks: the drive cannot home by itself"),
        };
        let supported = self.row(Question::Mode, &objects::SUPPORTED_MODES, Wanted::Words(set));
        let bit = i64::from(operation.supported_bit());
        if matches!(supported.found, Answer::Number(modes) if modes & bit == 0) {
            return supported.refusing(otherwise);
        }
        if !self.answer(&objects::MODE_OF_OPERATION_DISPLAY).is_there() {
            return self
                .row(Question::Mode, &objects::MODE_OF_OPERATION_DISPLAY, Wanted::Number(wanted))
                .refusing("another drive: the mode that it is in cannot be checked");
        }
        if !self.want(&objects::MODE_OF_OPERATION, wanted).is_met() {
            return self
                .row(Question::Mode, &objects::MODE_OF_OPERATION, Wanted::Number(wanted))
                .refusing("another drive, or another firmware");
        }
        match supported.found {
            Answer::Number(_) => supported,
            Answer::Absent => supported.noting("at start the drive must take the mode and show it, before brakes open"),
            _ => supported.noting(READ_AT_START),
        }
    }

    pub(super) fn cyclic_objects(&mut self) -> Finding {
        const CARRIED: [(&Object, PdoKind); 4] = [
            (&objects::CONTROLWORD, PdoKind::Receive),
            (&objects::STATUSWORD, PdoKind::Transmit),
            (&objects::POSITION_ACTUAL, PdoKind::Transmit),
            (&objects::TARGET_TORQUE, PdoKind::Receive),
        ];
        for (object, kind) in CARRIED {
            let known = self.answered(object);
            let (is_accessible, access) = match kind {
                PdoKind::Receive => (known.access.may_write(), "writable"),
                PdoKind::Transmit => (known.access.may_read(), "readable"),
            };
            let other_type = known.data_type.filter(|stated| !is_as_wide(*stated, object.data_type));
            if known.answer.is_there() && is_accessible && other_type.is_none() {
                continue;
            }
            let wanted = Wanted::Type(object.data_type, access);
            let row = self.row(Question::CyclicObjects, object, wanted);
            let found = other_type.map_or(row.found, Answer::OtherType);
            return Finding { found, ..row }.refusing("another drive");
        }
        self.row(Question::CyclicObjects, &objects::TARGET_TORQUE, Wanted::Words("there"))
    }

    /// The objects that the robot file writes: each there and writable. Those that read so already are not written.
    pub(super) fn writes(&mut self) -> Finding {
        let drive = self.drive;
        let wanted = Wanted::Words("writable, as drive.writes says");
        let mut refused = None;
        for setting in drive.settings.iter().chain(&drive.later_settings) {
            let Some(value) = Answer::of(setting.value).number() else { continue };
            let found = self.survey.at(setting.address);
            // Limits of a dictionary file are the maker's care, not always taken: the drive itself decides.
            let fits = found.answer == Answer::Number(value) || found.answer.is_there() && found.access.may_write();
            if !fits {
                refused = refused.or(Some((setting.address, found.answer)));
            }
        }
        let row = |object, found| Finding {
            question: Question::Writes,
            object,
            found,
            wanted,
            remedy: Remedy::None,
            verdict: Verdict::Works,
        };
        match refused {
            Some((object, found)) => row(object, found).refusing("leave it out of drive.writes"),
            None => {
                let first = drive.settings.first().or(drive.later_settings.first());
                let object = first.map_or(objects::ABORT_CONNECTION_OPTION.address(), |setting| setting.address);
                row(object, self.survey.at(object).answer)
            }
        }
    }

    pub(super) fn quick_stop(&mut self) -> Finding {
        self.row(
            Question::QuickStop,
            &objects::QUICK_STOP_OPTION,
            Wanted::Words("what the arm bears; it is the first step of every stop"),
        )
    }

    /// Whether the drive can home by itself; where it shall, with what is needed for it written.
    pub(super) fn homing(&mut self) -> Finding {
        let Operation::Homing(homing) = self.drive.operation else {
            let bit = i64::from(objects::HOMING_BIT);
            let knows = match self.answer(&objects::SUPPORTED_MODES) {
                Answer::Number(modes) => modes & bit != 0,
                _ => true,
            };
            let words = match (knows, self.answered(&objects::HOMING_METHOD)) {
                (true, found) if found.answer.is_there() && found.access.may_write() => {
                    "anything; it can home by itself"
                }
                _ => "anything; it cannot home by itself (6502h bit 5, 6098h), and need not",
            };
            return self.row(Question::Homing, &objects::HOMING_METHOD, Wanted::Words(words));
        };
        let row = self.row(Question::Homing, &objects::HOMING_METHOD, Wanted::Number(homing.method.into()));
        let mut refused = None;
        for (object, wanted) in homing.objects() {
            let none_wanted = object == &objects::HOME_OFFSET && wanted == 0;
            let fit = self.want(object, wanted);
            // Without the object there is no offset, and that is what is wanted.
            if !(fit.is_met() || none_wanted && fit == Fit::Absent) {
                let row = self.row(Question::Homing, object, Wanted::Number(wanted));
                refused =
                    refused.or(Some(row.refusing("another encoder.homing, which the drive takes, or a pose at marks")));
            }
        }
        refused.unwrap_or(row)
    }

    /// 1017h.
    pub(super) fn drive_heartbeat(&mut self) -> Finding {
        let wanted = i64::from(self.protocol.heartbeats.drive_period());
        let row = self.row(Question::DriveHeartbeat, &objects::PRODUCER_HEARTBEAT_TIME, Wanted::Number(wanted));
        match self.want(&objects::PRODUCER_HEARTBEAT_TIME, wanted) {
            Fit::AsWanted | Fit::Written => row,
            Fit::Absent => row.refusing("another drive: node guarding is not supported"),
            Fit::CannotBeWritten => {
                let sent = row.found.number().and_then(|found| u16::try_from(found).ok()).filter(|sent| *sent > 0);
                match sent.filter(|_| !self.answered(&objects::PRODUCER_HEARTBEAT_TIME).access.may_write()) {
                    Some(sent) => row.with(Verdict::WorksWith, Remedy::DriveHeartbeat(sent)),
                    None => {
                        row.with(Verdict::Cannot, Remedy::RobotFile("[bus] drive_heartbeat_ms that the drive takes"))
                    }
                }
            }
        }
    }
}

//! What is written to a drive, and what is said of it: from what was learned of the drive and what the robot wants.
//!
//! [`plan`] is a pure function. The master calls it with what the drive answered; a dictionary file is judged by it with
//! what the file says.

mod bus;
mod device;
mod finding;
mod pdos;
mod planner;
mod readings;
mod scales;

pub use bus::interpolation_times;
pub use finding::{Finding, Question, Remedy, Verdict, Wanted, WriteEntry};
pub use planner::{MOST_PLANNED, PlannedSettings};

use crate::drive::survey::{Answer, ObjectSource, Survey};
use crate::drive::wishes::{DriveConfiguration, Protocol, Setting, Settings};
use planner::Planner;

/// One finding for each question.
pub type Findings = heapless::Vec<Finding, { Question::ALL.len() }>;

/// What is to be written, and what is to be said.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What is written, in this order; what reads so already is left out.
    pub settings: PlannedSettings,
    /// What was found, one for each of [`Question::ALL`], in its order.
    pub findings: Findings,
}

impl Plan {
    /// The worst verdict.
    pub fn verdict(&self) -> Verdict {
        self.findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Works)
    }

    /// The first finding with which a drive must not be started.
    pub fn refusal(&self) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.refuses_start())
    }

    /// What is to be known, though nothing is refused.
    pub fn notes(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| finding.verdict != Verdict::Works)
    }
}

/// Plans the start of a drive.
///
/// Settings are in the order of writing: the robot file's, the protocol's, the robot file's later ones. Nothing of it
/// may be written while [`Plan::refusal`] has something to say.
pub fn plan(survey: &Survey, drive: &DriveConfiguration, protocol: &Protocol) -> Plan {
    let mut planner = Planner { survey, drive, protocol, settings: PlannedSettings::new() };
    write_before(&mut planner, &drive.settings);
    let findings = Question::ALL.iter().map(|question| answer(&mut planner, *question)).collect();
    write_after(&mut planner, &drive.later_settings);
    Plan { settings: planner.settings, findings }
}

/// The robot file's objects that come before the protocol's, without those that read so already.
fn write_before(planner: &mut Planner<'_>, settings: &Settings) {
    for setting in settings {
        let again = settings.iter().filter(|other| other.address == setting.address).count() > 1;
        if again || !reads_so(planner, setting) {
            planner.push(*setting);
        }
    }
}

/// Those that come after: if anything is written at all, since it may change what reads so now.
fn write_after(planner: &mut Planner<'_>, settings: &Settings) {
    if !planner.settings.is_empty() || settings.iter().any(|setting| !reads_so(planner, setting)) {
        settings.iter().for_each(|setting| planner.push(*setting));
    }
}

fn reads_so(planner: &Planner<'_>, setting: &Setting) -> bool {
    planner.survey.at(setting.address).answer == Answer::of(setting.value)
}

fn answer(planner: &mut Planner<'_>, question: Question) -> Finding {
    match question {
        Question::DeviceType => planner.device_type(),
        Question::Identity => planner.identity(),
        Question::Mode => planner.mode(),
        Question::CyclicObjects => planner.cyclic_objects(),
        Question::RatedTorque => planner.rated_torque(),
        Question::TorqueLimits => planner.torque_limits(),
        Question::Resolution => planner.resolution(),
        Question::PositionUnits => planner.position_units(),
        Question::Polarity => planner.polarity(),
        Question::Writes => planner.writes(),
        Question::Command => planner.command(),
        Question::Feedback => planner.feedback(),
        Question::TorqueFeedback => planner.torque_feedback(),
        Question::OtherPdos => planner.other_pdos(),
        Question::Sync => planner.sync(),
        Question::Period => planner.period(),
        Question::DriveHeartbeat => planner.drive_heartbeat(),
        Question::Emergency => planner.emergency(),
        Question::Watchdog => planner.watchdog(),
        Question::LossReaction => planner.loss_reaction(),
        Question::QuickStop => planner.quick_stop(),
        Question::Homing => planner.homing(),
        Question::Readings => planner.readings(),
        Question::PowerMarker => planner.power_marker(),
    }
}

/// Asks a drive, or its dictionary file, for everything that [`plan`] looks at.
///
/// # Errors
/// That of the source.
pub fn survey_of<S: ObjectSource>(source: &mut S, drive: &DriveConfiguration) -> Result<Survey, S::Error> {
    Survey::of(source, named_objects(drive), |kind, number| drive.pdos.uses(kind, number))
}

/// The objects that a survey has to ask for beside its own: those that the robot file names.
fn named_objects(
    drive: &DriveConfiguration,
) -> impl Iterator<Item = (canopen_rs::Address, Option<canopen_rs::DataType>)> {
    use crate::drive::wishes::{Operation, Resolution};
    let resolution = match drive.resolution {
        Resolution::Object { address, .. } => Some((address, None)),
        Resolution::Standard | Resolution::Stated => None,
    };
    let homing = match drive.operation {
        Operation::Homing(homing) => Some(homing),
        Operation::CyclicTorque => None,
    };
    let homing = homing
        .into_iter()
        .flat_map(|homing| homing.objects().map(|(object, _)| (object.address(), Some(object.data_type))));
    let of = |setting: &Setting| (setting.address, Some(setting.value.data_type()));
    let read = drive.readings.iter().flatten().map(|reading| (reading.object, Some(reading.data_type)));
    let written = drive.settings.iter().chain(&drive.later_settings).chain(&drive.power_marker).map(of);
    written.chain(resolution).chain(homing).chain(read)
}

#[cfg(test)]
mod tests;

//! What a robot wants of a joint's drive: checked.

use uarm_io::drive::pdo_objects::{PdoKind, PdoNumber};
use uarm_io::drive::power_marker::conflict;
use uarm_io::drive::wishes::{
    AbortOption, DriveConfiguration, MAX_SETTINGS, PdoChannel, Pdos, PinnedIdentity, Resolution, Setting, Settings,
    TorqueApplies, TorqueReference, Watchdog, WatchdogTest,
};
use uarm_io::drive::words::Named;
use uarm_io::drive::{Address, NodeId, Value};
use uarm_io::embedded_can::StandardId;
use uarm_io::torque::{RatedTorque, TorqueCeiling};

use super::error::{Checker, RobotError};
use super::file::{self, RobotFile};
use super::readings;

/// Identifiers that CANopen leaves to PDOs (CiA 301, table of restricted identifiers).
const PDO_IDENTIFIERS: std::ops::RangeInclusive<u16> = 0x181..=0x580;
/// Identifier of the second TPDO in the predefined connection set, without the node.
const TPDO2_BASE: u16 = 0x280;
/// A drive that watches its commands must bear that two of them are late.
const LEAST_COMMANDS_IN_TIMEOUT: u32 = 3;

/// Checks the fields of one joint's drive.
pub(super) struct DriveCheck<'a, const N: usize> {
    pub(super) index: usize,
    pub(super) joint: &'a file::Joint,
    pub(super) file: &'a RobotFile<N>,
    pub(super) check: &'a Checker<'a>,
}

impl<const N: usize> DriveCheck<'_, N> {
    fn drive(&self) -> &file::Drive {
        &self.joint.drive
    }

    fn field(&self, name: &str) -> String {
        format!("joints[{}].drive.{name}", self.index)
    }

    /// What the master wants of the drive of `node`.
    pub(super) fn configuration(
        &self,
        node: NodeId,
        rated_torque: RatedTorque,
        torque_ceiling: TorqueCeiling,
    ) -> Result<DriveConfiguration, RobotError> {
        let torque_applies = self.drive().torque_applies.unwrap_or_default();
        let file::Identity { vendor, product, serial } = self.drive().identity;
        let configuration = DriveConfiguration {
            identity: PinnedIdentity { vendor, product, serial },
            resolution: self.resolution(),
            torque_reference: self.torque_reference()?,
            torque_ceiling,
            torque_applies,
            command_transmission: self.command_transmission(torque_applies)?,
            pdos: self.pdos(node)?,
            watchdog: self.watchdog()?,
            abort_option: self.abort_option()?,
            readings: readings::check(self.index, self.drive(), self.file, self.check)?,
            power_marker: self.joint.encoder.power_marker.as_ref().and_then(power_marker),
            settings: self.settings(file::When::Before)?,
            later_settings: self.settings(file::When::After)?,
            ..DriveConfiguration::new(node, self.joint.encoder.counts_per_revolution, rated_torque)
        };
        if let (Some(marker), Some(expected)) = (configuration.power_marker, conflict(&configuration)) {
            let field = format!("joints[{}].encoder.power_marker", self.index);
            return Err(self.check.refuse(field, Named(marker.address), expected));
        }
        Ok(configuration)
    }

    fn resolution(&self) -> Resolution {
        let encoder = &self.joint.encoder;
        match encoder.resolution_object {
            None | Some(file::ResolutionObject::Named(file::NamedResolution::Standard)) => Resolution::Standard,
            Some(file::ResolutionObject::Named(file::NamedResolution::Absent)) => Resolution::Stated,
            Some(file::ResolutionObject::Object(file::MakersObject { index, subindex, equals })) => {
                Resolution::Object { address: Address::new(index, subindex), equals }
            }
        }
    }

    fn torque_reference(&self) -> Result<TorqueReference, RobotError> {
        let named = self.drive().target_torque_of.unwrap_or_default();
        match (named, self.drive().rated_current_ma) {
            (file::TargetTorqueOf::RatedTorque, None) => Ok(TorqueReference::RatedTorque),
            (file::TargetTorqueOf::StatedTorque, None) => Ok(TorqueReference::StatedTorque),
            (file::TargetTorqueOf::RatedCurrent, Some(milliamperes)) if milliamperes > 0 => {
                Ok(TorqueReference::RatedCurrent { milliamperes })
            }
            (_, found) => {
                let found = found.map_or("absent".to_owned(), |found| found.to_string());
                let expected = "mA above 0 with target_torque_of = \"rated-current\", and absent otherwise";
                Err(self.check.refuse(self.field("rated_current_ma"), found, expected))
            }
        }
    }

    fn command_transmission(&self, applies: TorqueApplies) -> Result<Option<u8>, RobotError> {
        let Some(transmission) = self.drive().pdo.as_ref().and_then(|pdo| pdo.rpdo_transmission) else {
            return Ok(None);
        };
        if TorqueApplies::of_transmission_type(transmission) == Some(applies) {
            return Ok(Some(transmission));
        }
        let expected = match applies {
            TorqueApplies::OnReception => "254 or 255, as torque_applies = \"on-reception\" means",
            TorqueApplies::AtSync => "0 to 240, as torque_applies = \"at-sync\" means",
        };
        Err(self.check.refuse(self.field("pdo.rpdo_transmission"), transmission, expected))
    }

    fn pdos(&self, node: NodeId) -> Result<Pdos, RobotError> {
        let mut pdos = Pdos::predefined(node);
        let Some(pdo) = &self.drive().pdo else { return Ok(pdos) };
        pdos.command = self.channel("pdo.rpdo", pdo.rpdo, "pdo.rpdo_id", pdo.rpdo_id, pdos.command)?;
        pdos.feedback = self.channel("pdo.tpdo", pdo.tpdo, "pdo.tpdo_id", pdo.tpdo_id, pdos.feedback)?;
        if let Some(number) = pdo.torque_tpdo {
            let identifier = TPDO2_BASE | u16::from(node.raw());
            let predefined = PdoChannel {
                number: PdoNumber::SECOND,
                identifier: StandardId::new(identifier).unwrap_or(StandardId::MAX),
            };
            let torque =
                self.channel("pdo.torque_tpdo", Some(number), "pdo.torque_tpdo_id", pdo.torque_tpdo_id, predefined)?;
            if torque.number == pdos.feedback.number {
                return Err(self.check.refuse(self.field("pdo.torque_tpdo"), number, "another TPDO than pdo.tpdo"));
            }
            pdos.torque_feedback = Some(torque);
        } else if let Some(identifier) = pdo.torque_tpdo_id {
            return Err(self.check.refuse(self.field("pdo.torque_tpdo_id"), identifier, "pdo.torque_tpdo beside it"));
        }
        for (name, kind, numbers) in [
            ("pdo.keep_rpdos", PdoKind::Receive, &pdo.keep_rpdos),
            ("pdo.keep_tpdos", PdoKind::Transmit, &pdo.keep_tpdos),
        ] {
            for found in numbers {
                let expected = "numbers from 1 to 512 that are not in use, eight in all at most";
                let number = PdoNumber::new(*found).filter(|number| !pdos.uses(kind, *number));
                let kept = number.map(|number| pdos.kept.push((kind, number)));
                if !matches!(kept, Some(Ok(()))) {
                    return Err(self.check.refuse(self.field(name), found, expected));
                }
            }
        }
        Ok(pdos)
    }

    fn channel(
        &self,
        number_field: &str,
        number: Option<u16>,
        identifier_field: &str,
        identifier: Option<u16>,
        otherwise: PdoChannel,
    ) -> Result<PdoChannel, RobotError> {
        let number = match number {
            None => otherwise.number,
            Some(number) => PdoNumber::new(number).ok_or_else(|| {
                self.check.refuse(self.field(number_field), number, format!("1 to {}", PdoNumber::MOST))
            })?,
        };
        let identifier = match identifier {
            None => otherwise.identifier,
            Some(raw) => StandardId::new(raw).filter(|_| PDO_IDENTIFIERS.contains(&raw)).ok_or_else(|| {
                let expected = format!("{} to {} (181h to 580h)", PDO_IDENTIFIERS.start(), PDO_IDENTIFIERS.end());
                self.check.refuse(self.field(identifier_field), raw, expected)
            })?,
        };
        Ok(PdoChannel { number, identifier })
    }

    fn watchdog(&self) -> Result<Watchdog, RobotError> {
        let drive = self.drive();
        let beside = "absent without watchdog = \"rpdo-timeout\"";
        match drive.watchdog.unwrap_or_default() {
            file::Watchdog::Heartbeat => match (drive.rpdo_timeout_ms, &drive.watchdog_test) {
                (None, None) => Ok(Watchdog::Heartbeat),
                (Some(found), _) => Err(self.check.refuse(self.field("rpdo_timeout_ms"), found, beside)),
                (_, Some(found)) => Err(self.check.refuse(self.field("watchdog_test"), found, beside)),
            },
            file::Watchdog::RpdoTimeout => {
                let period = u64::from(self.file.control.period_us);
                let least = (u64::from(LEAST_COMMANDS_IN_TIMEOUT) * period).div_ceil(1000);
                let milliseconds =
                    drive.rpdo_timeout_ms.filter(|found| u64::from(*found) >= least).ok_or_else(|| {
                        let found = drive.rpdo_timeout_ms.map_or("absent".to_owned(), |found| found.to_string());
                        let expected = format!("at least {least}, {LEAST_COMMANDS_IN_TIMEOUT} periods of the loop");
                        self.check.refuse(self.field("rpdo_timeout_ms"), found, expected)
                    })?;
                Ok(Watchdog::RpdoTimeout { milliseconds, test: self.watchdog_test()? })
            }
        }
    }

    fn watchdog_test(&self) -> Result<WatchdogTest, RobotError> {
        /// The text that stands for a test at each start.
        const AT_START: &str = "at-start";
        match self.drive().watchdog_test.as_deref() {
            None | Some(AT_START) => Ok(WatchdogTest::AtStart),
            Some(text) if !text.trim().is_empty() => Ok(WatchdogTest::ByHand),
            Some(text) => {
                let expected = format!("\"{AT_START}\", or how it was tried by hand");
                Err(self.check.refuse(self.field("watchdog_test"), format!("{text:?}"), expected))
            }
        }
    }

    fn abort_option(&self) -> Result<AbortOption, RobotError> {
        match self.drive().without_6007h.as_deref() {
            None => Ok(AbortOption::Required),
            Some(text) if !text.trim().is_empty() => Ok(AbortOption::Explained),
            Some(text) => {
                let expected = "how it is known that the drive brakes without its master";
                Err(self.check.refuse(self.field("without_6007h"), format!("{text:?}"), expected))
            }
        }
    }

    fn settings(&self, when: file::When) -> Result<Settings, RobotError> {
        let mut settings = Settings::new();
        for (number, write) in self.drive().writes.iter().enumerate() {
            if write.when.unwrap_or_default() != when {
                continue;
            }
            let setting = Setting::new(Address::new(write.index, write.subindex), self.value(number, write)?);
            settings.push(setting).map_err(|_| {
                let found = format!("{} objects", self.drive().writes.len());
                self.check.refuse(self.field("writes"), found, format!("at most {MAX_SETTINGS} before and after each"))
            })?;
        }
        Ok(settings)
    }

    fn value(&self, number: usize, write: &file::ObjectWrite) -> Result<Value, RobotError> {
        write.as_value().ok_or_else(|| {
            let field = self.field(&format!("writes[{number}].value"));
            self.check.refuse(field, write.value, format!("a value that fits type {:?}", write.kind))
        })
    }
}

/// The mark of an incremental encoder; its value was checked with the encoder.
fn power_marker(marker: &file::ObjectWrite) -> Option<Setting> {
    Some(Setting::new(Address::new(marker.index, marker.subindex), marker.as_value()?))
}

/// Refuses PDOs of two drives with one identifier.
pub(super) fn check_identifiers(drives: &[&DriveConfiguration], check: &Checker<'_>) -> Result<(), RobotError> {
    let mut taken: Vec<StandardId> = Vec::new();
    for (index, drive) in drives.iter().enumerate() {
        let Pdos { command, feedback, torque_feedback, .. } = &drive.pdos;
        for channel in [command, feedback].into_iter().chain(torque_feedback) {
            if taken.contains(&channel.identifier) {
                let field = format!("joints[{index}].drive.pdo");
                let found = format!("identifier {:03X}h", channel.identifier.as_raw());
                return Err(check.refuse(field, found, "an identifier for each PDO of each joint"));
            }
            taken.push(channel.identifier);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use uarm_io::drive::Address;
    use uarm_io::drive::pdo_objects::{PdoKind, PdoNumber};
    use uarm_io::drive::wishes::{
        AbortOption, DriveConfiguration, PinnedIdentity, Resolution, TorqueApplies, TorqueReference, Watchdog,
        WatchdogTest,
    };
    use uarm_io::torque::TorqueUnit;

    use crate::robot::overrides::Overrides;
    use crate::robot::{BUILT_IN, Robot};

    const WRITES: &str = "writes = [{ index = 0x6007, subindex = 0, type = \"i16\", value = 1 }] }";

    fn parse(text: &str) -> Result<Robot, String> {
        Robot::parse(Path::new("test.toml"), text, &Overrides::default()).map_err(|error| error.to_string())
    }

    /// The drive of the first joint, with `fields` in its table.
    fn drive(fields: &str) -> Result<DriveConfiguration, String> {
        let text = BUILT_IN.replacen(WRITES, &format!("{fields} }}"), 1);
        assert_ne!(text, BUILT_IN);
        parse(&text).map(|robot| robot.description.joints[0].drive.clone())
    }

    /// What is said of `fields`.
    #[track_caller]
    fn refused(fields: &str, parts: &[&str]) {
        let message = drive(fields).unwrap_err();
        for part in parts {
            assert!(message.contains(part), "{message}: expected {part}");
        }
    }

    fn encoder(fields: &str) -> Result<DriveConfiguration, String> {
        let text = BUILT_IN.replacen("zero_counts = 0 }", &format!("zero_counts = 0, {fields} }}"), 1);
        parse(&text).map(|robot| robot.description.joints[0].drive.clone())
    }

    #[test]
    fn an_identity_may_be_pinned_in_part() {
        assert_eq!(drive("").unwrap().identity, PinnedIdentity::default());
        let pinned = drive("identity = { vendor = 0x9A, serial = 1001 }").unwrap().identity;
        assert_eq!(pinned, PinnedIdentity { vendor: Some(154), product: None, serial: Some(1001) });
        let message = drive("identity = { maker = 1 }").unwrap_err();
        assert!(message.contains("maker"), "{message}");
    }

    #[test]
    fn without_the_optional_fields_it_is_as_it_was() {
        let drive = drive("").unwrap();
        let node = drive.node;
        let expected = DriveConfiguration::new(node, 33_739, drive.rated_torque);
        assert_eq!(drive, DriveConfiguration { torque_ceiling: drive.torque_ceiling, ..expected });
    }

    #[test]
    fn the_resolution_can_stand_elsewhere_or_nowhere() {
        assert_eq!(encoder("resolution_object = \"608F\"").unwrap().resolution, Resolution::Standard);
        assert_eq!(encoder("resolution_object = \"absent\"").unwrap().resolution, Resolution::Stated);
        let own = encoder("resolution_object = { index = 0x3010, subindex = 4, equals = 8192 }").unwrap();
        assert_eq!(own.resolution, Resolution::Object { address: Address::new(0x3010, 4), equals: 8192 });
        let message = encoder("resolution_object = \"6090\"").unwrap_err();
        assert!(message.contains("\"608F\", \"absent\" or { index, subindex, equals }"), "{message}");
    }

    #[test]
    fn torque_has_a_unit_and_something_it_refers_to() {
        let micro = drive("rated_torque_unit = \"uNm\"").unwrap();
        assert_eq!(
            (micro.rated_torque.object_value(), micro.rated_torque.unit()),
            (200_000, TorqueUnit::MicronewtonMetre)
        );
        let stated = drive("target_torque_of = \"stated-torque\"").unwrap();
        assert_eq!(stated.torque_reference, TorqueReference::StatedTorque);
        let current = drive("target_torque_of = \"rated-current\", rated_current_ma = 3000").unwrap();
        assert_eq!(current.torque_reference, TorqueReference::RatedCurrent { milliamperes: 3000 });
        refused("target_torque_of = \"rated-current\"", &["joints[0].drive.rated_current_ma = absent", "mA above 0"]);
        refused("rated_current_ma = 3000", &["joints[0].drive.rated_current_ma = 3000", "absent otherwise"]);
        refused("rated_torque_unit = \"Nm\"", &["rated_torque_unit", "mNm"]);
    }

    #[test]
    fn torque_applies_on_reception_or_at_the_sync() {
        let at_sync = drive("torque_applies = \"at-sync\"").unwrap();
        assert_eq!((at_sync.torque_applies, at_sync.command_transmission), (TorqueApplies::AtSync, None));
        assert_eq!(drive("pdo = { rpdo_transmission = 254 }").unwrap().command_transmission, Some(254));
        let none = drive("torque_applies = \"at-sync\", pdo = { rpdo_transmission = 0 }").unwrap();
        assert_eq!(none.command_transmission, Some(0));
        refused("pdo = { rpdo_transmission = 1 }", &["joints[0].drive.pdo.rpdo_transmission = 1", "254 or 255"]);
        refused("pdo = { rpdo_transmission = 250 }", &["rpdo_transmission = 250"]);
    }

    #[test]
    fn pdos_have_numbers_and_identifiers() {
        let pdos = drive(
            "pdo = { rpdo = 3, rpdo_id = 0x333, tpdo = 4, tpdo_id = 0x1F1, torque_tpdo = 2, keep_rpdos = [1], \
             keep_tpdos = [1] }",
        )
        .unwrap()
        .pdos;
        assert_eq!((pdos.command.number.get(), pdos.command.identifier.as_raw()), (3, 0x333));
        assert_eq!((pdos.feedback.number.get(), pdos.feedback.identifier.as_raw()), (4, 0x1F1));
        let torque = pdos.torque_feedback.unwrap();
        assert_eq!((torque.number.get(), torque.identifier.as_raw()), (2, 0x281));
        assert_eq!(pdos.kept.as_slice(), [(PdoKind::Receive, PdoNumber::FIRST), (PdoKind::Transmit, PdoNumber::FIRST)]);
        refused("pdo = { rpdo = 513 }", &["joints[0].drive.pdo.rpdo = 513", "1 to 512"]);
        refused("pdo = { tpdo_id = 0x581 }", &["joints[0].drive.pdo.tpdo_id = 1409", "181h to 580h"]);
        refused("pdo = { torque_tpdo = 1 }", &["joints[0].drive.pdo.torque_tpdo = 1", "another TPDO"]);
        refused("pdo = { torque_tpdo_id = 0x281 }", &["joints[0].drive.pdo.torque_tpdo_id", "torque_tpdo beside it"]);
        refused("pdo = { keep_tpdos = [1] }", &["joints[0].drive.pdo.keep_tpdos = 1", "not in use"]);
        // The second joint's TPDO1 has it.
        refused("pdo = { tpdo_id = 0x182 }", &["joints[1].drive.pdo = identifier 182h", "for each PDO"]);
    }

    #[test]
    fn another_watchdog_is_named_with_its_time_and_test() {
        let at_start = drive("watchdog = \"rpdo-timeout\", rpdo_timeout_ms = 9").unwrap();
        assert_eq!(at_start.watchdog, Watchdog::RpdoTimeout { milliseconds: 9, test: WatchdogTest::AtStart });
        let by_hand =
            drive("watchdog = \"rpdo-timeout\", rpdo_timeout_ms = 20, watchdog_test = \"cable pulled\"").unwrap();
        assert_eq!(by_hand.watchdog, Watchdog::RpdoTimeout { milliseconds: 20, test: WatchdogTest::ByHand });
        refused("watchdog = \"rpdo-timeout\"", &["joints[0].drive.rpdo_timeout_ms = absent", "at least 9"]);
        refused("watchdog = \"rpdo-timeout\", rpdo_timeout_ms = 8", &["rpdo_timeout_ms = 8", "at least 9, 3 periods"]);
        refused("rpdo_timeout_ms = 20", &["rpdo_timeout_ms = 20", "absent without watchdog"]);
        refused("watchdog_test = \"pulled\"", &["watchdog_test = pulled", "absent without watchdog"]);
        refused(
            "watchdog = \"rpdo-timeout\", rpdo_timeout_ms = 20, watchdog_test = \" \"",
            &["watchdog_test = \" \"", "how it was tried"],
        );
    }

    #[test]
    fn a_drive_without_6007h_needs_words() {
        let explained = drive("without_6007h = \"its firmware faults; tried\"").unwrap();
        assert_eq!(explained.abort_option, AbortOption::Explained);
        refused("without_6007h = \"\"", &["joints[0].drive.without_6007h = \"\"", "how it is known"]);
    }

    #[test]
    fn writes_come_before_or_after() {
        let entry = |value: usize, when: &str| {
            format!("{{ index = 0x2000, subindex = 0, type = \"u8\", value = {value}{when} }}")
        };
        let entries = [entry(1, ", when = \"after\""), entry(2, ""), entry(3, ", when = \"before\"")].join(", ");
        let drive = drive(&format!("writes = [{entries}]")).unwrap();
        assert_eq!((drive.settings.len(), drive.later_settings.len()), (2, 1));
        let many = vec![entry(1, ""); 33].join(", ");
        refused(&format!("writes = [{many}]"), &["joints[0].drive.writes = 33 objects", "at most 32"]);
        refused(&format!("writes = [{}]", entry(300, "")), &["writes[0].value = 300"]);
    }
}

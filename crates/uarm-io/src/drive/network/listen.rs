//! Who else commands this bus: frames that only the drives' own master sends, from somebody else.
//!
//! Before it sends anything a master listens for them, and from then on it stops when it hears one.

use super::blocking::{Blocking, Voice};
use super::configuration::NetworkConfiguration;
use super::error::StartError;
use super::foreign::ForeignFrame;
use super::master::BusClaim;
use crate::drive::wire::{self, Channel};
use crate::drive::wishes::DriveConfiguration;
use crate::link::Link;
use crate::time::Clock;
use embedded_can::StandardId;

/// Identifiers of RPDO1 to RPDO4, without the node (CiA 301, predefined connection set).
const RPDO_BASES: [u16; 4] = [0x200, 0x300, 0x400, 0x500];

/// The identifiers that a master of a drive sends to it: its RPDOs, where the configuration puts them and where they are by
/// default, and SDO requests.
fn to_drive(drive: &DriveConfiguration) -> impl Iterator<Item = (StandardId, ForeignFrame)> {
    let node = drive.node.raw();
    let command = drive.pdos.command.identifier;
    let predefined = RPDO_BASES.into_iter().filter_map(move |base| StandardId::new(base | u16::from(node)));
    let rpdos = predefined.filter(move |identifier| *identifier != command).chain([command]);
    let request = (Channel::SdoRequest(drive.node).identifier(), ForeignFrame::SdoRequest { node });
    rpdos
        .map(move |identifier| (identifier, ForeignFrame::Rpdo { node, identifier: identifier.as_raw() }))
        .chain([request])
}

/// The identifiers that a master sends to all.
fn to_all() -> [(StandardId, ForeignFrame); 3] {
    [
        (Channel::NmtCommand.identifier(), ForeignFrame::NmtCommand),
        (Channel::Sync.identifier(), ForeignFrame::Sync),
        (wire::master_heartbeat_frame().id(), ForeignFrame::MasterHeartbeat),
    ]
}

impl<const JOINTS: usize> NetworkConfiguration<JOINTS> {
    /// The identifiers that nobody but this master may use, and what a frame with one is.
    pub(super) fn foreign(&self) -> impl Iterator<Item = (StandardId, ForeignFrame)> {
        let drives = self.drives();
        let feedback = |identifier| drives.iter().any(|drive| drive.pdos.feedback.identifier == identifier);
        to_all()
            .into_iter()
            .chain(drives.iter().flat_map(to_drive))
            .filter(move |(identifier, _)| !feedback(*identifier))
    }
}

impl<L: Link, C: Clock, const JOINTS: usize> Blocking<'_, L, C, JOINTS> {
    /// Listens without sending anything, as long as the configuration says.
    pub(super) fn listen(&mut self) -> Result<(), StartError<L::Error>> {
        self.voice = Voice::Silent;
        self.network.claim = BusClaim::Free;
        let listen = self.network.configuration.listen;
        self.pause(listen)?;
        self.voice = Voice::Heartbeats;
        match self.undisturbed() {
            Ok(()) => Ok(()),
            Err(heard) => {
                self.network.claim = BusClaim::AnotherMasters;
                Err(StartError::Disturbed(heard))
            }
        }
    }
}

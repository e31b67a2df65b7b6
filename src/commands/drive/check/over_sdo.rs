//! A drive on the bus answers for itself.

use uarm_io::drive::NodeId;
use uarm_io::drive::plan::survey_of;
use uarm_io::drive::sdo::{Bystander, DriveObjects, Patience, SdoError};
use uarm_io::drive::survey::Survey;
use uarm_io::drive::wishes::DriveConfiguration;
use uarm_io::link::Received;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{InterfaceName, Reception, SocketCanError, SocketCanLink};

use crate::commands::drive::patient_link::PatientLink;
use crate::sdo_access;

/// A drive that is read, and nothing else but made to answer if it is stopped.
pub struct Drive {
    link: PatientLink<SocketCanLink>,
    node: NodeId,
    patience: Patience,
}

impl Drive {
    /// The drive of `node` on an interface.
    ///
    /// # Errors
    /// If the interface cannot be used, or the drive does not answer.
    pub fn open(interface: InterfaceName, node: NodeId, patience: Patience) -> anyhow::Result<Self> {
        let identifiers = sdo_access::identifiers(node);
        let mut link = PatientLink(SocketCanLink::open(interface, Reception::Exactly(&identifiers))?);
        sdo_access::ensure(&mut link, &MonotonicClock, node)?;
        Ok(Self { link, node, patience })
    }

    /// What it says of itself.
    ///
    /// # Errors
    /// If it does not answer, or the link fails.
    pub fn survey(&mut self, wishes: &DriveConfiguration) -> Result<Survey, SdoError<SocketCanError>> {
        let mut bystander = Bystander::new(&mut self.link, &MonotonicClock, self.patience, |_: &Received| {});
        survey_of(&mut DriveObjects::new(&mut bystander, self.patience, self.node), wishes)
    }
}

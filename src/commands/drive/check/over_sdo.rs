//! A drive on the bus answers for itself.

use uarm_io::drive::NodeId;
use uarm_io::drive::plan::survey_of;
use uarm_io::drive::sdo::{Bystander, DriveObjects, Patience, SdoError};
use uarm_io::drive::survey::Survey;
use uarm_io::drive::wire::Channel;
use uarm_io::drive::wishes::DriveConfiguration;
use uarm_io::link::Received;
use uarm_io::monotonic::MonotonicClock;
use uarm_io::socketcan_link::{InterfaceName, OpenError, Reception, SocketCanError, SocketCanLink};

use crate::commands::drive::patient_link::PatientLink;

/// A drive that is read, and nothing else.
pub struct Drive {
    link: PatientLink<SocketCanLink>,
    node: NodeId,
    patience: Patience,
}

impl Drive {
    /// The drive of `node` on an interface.
    ///
    /// # Errors
    /// If the interface cannot be used.
    pub fn open(interface: InterfaceName, node: NodeId, patience: Patience) -> Result<Self, OpenError> {
        let identifiers = [Channel::SdoResponse(node).identifier()];
        let link = PatientLink(SocketCanLink::open(interface, Reception::Exactly(&identifiers))?);
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

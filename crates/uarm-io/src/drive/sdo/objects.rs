//! A drive that answers for its own objects.

use super::{Patience, SdoError, SdoPort};
use crate::drive::objects::Object;
use crate::drive::survey::{Answer, Answered, ObjectSource};
use canopen_rs::NodeId;

/// SDO abort codes that say that there is no such object, and no such sub-index.
const ABSENT: [u32; 2] = [0x0602_0000, 0x0609_0011];

/// The objects of one drive, over SDO.
#[derive(Debug)]
pub struct DriveObjects<'p, P> {
    port: &'p mut P,
    patience: Patience,
    node: NodeId,
}

impl<'p, P: SdoPort> DriveObjects<'p, P> {
    /// The objects of the drive of `node`.
    pub const fn new(port: &'p mut P, patience: Patience, node: NodeId) -> Self {
        Self { port, patience, node }
    }
}

impl<P: SdoPort> ObjectSource for DriveObjects<'_, P> {
    type Error = SdoError<P::Error>;

    fn ask(&mut self, object: &Object) -> Result<Answered, Self::Error> {
        let answer = match super::read(self.port, self.patience, self.node, object.address(), object.data_type) {
            Ok(value) => Answer::of(value),
            Err(SdoError::Abort { code, .. }) if ABSENT.contains(&code) => Answer::Absent,
            Err(SdoError::Abort { code, .. }) => Answer::Refused(code),
            // A text, a domain, or a number of another length.
            Err(SdoError::Response { .. }) => Answer::NotANumber,
            Err(error) => return Err(error),
        };
        Ok(Answered::by_drive(answer))
    }
}

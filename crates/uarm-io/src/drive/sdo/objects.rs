//! A drive that answers for its own objects.

use super::{Patience, SdoError, SdoPort};
use crate::drive::objects::Object;
use crate::drive::survey::{Answered, ObjectSource};
use canopen_rs::NodeId;

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
        super::answered(super::read(self.port, self.patience, self.node, object.address(), object.data_type))
    }
}

//! What a drive shows of itself that a reference is held against.

use std::time::Duration;

use uarm_io::drive::cia402::Statusword;
use uarm_io::drive::objects::{self, Object};
use uarm_io::drive::sdo::{self, Bystander, Patience, SdoError};
use uarm_io::drive::{Address, NodeId, Value};
use uarm_io::link::{Link, Received};
use uarm_io::time::Clock;

use crate::robot::file::{Encoder, ObjectWrite};
use crate::sdo_access;

const PATIENCE: Patience = Patience { timeout: Duration::from_millis(200), attempts: 3 };

/// What a drive shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// 1018h:01, if it has one.
    pub vendor: Option<u32>,
    /// 1018h:02, if it has one.
    pub product: Option<u32>,
    /// 1018h:04, if it has one.
    pub serial: Option<u32>,
    /// 6041h.
    pub statusword: Statusword,
    /// 6064h.
    pub position: i32,
    /// What the marker's object reads, if the robot file names one.
    pub marker: Option<Value>,
}

/// Reads what the drive of `node` shows; `encoder` names its marker.
///
/// # Errors
/// If the drive does not answer, or has no statusword, position or marker.
pub fn show<L: Link, C: Clock>(link: &mut L, clock: &C, node: NodeId, encoder: &Encoder) -> anyhow::Result<Shown>
where
    L::Error: Send + Sync + 'static,
{
    sdo_access::ensure(link, clock, node)?;
    let mut bus = Bystander::new(link, clock, PATIENCE, |_| {});
    let vendor = number(&mut bus, node, &objects::VENDOR_ID)?;
    let product = number(&mut bus, node, &objects::PRODUCT_CODE)?;
    let serial = number(&mut bus, node, &objects::SERIAL_NUMBER)?;
    let statusword = match bus.read(node, &objects::STATUSWORD)? {
        Value::Unsigned16(bits) => Statusword::from_bits(bits),
        value => anyhow::bail!("node {}: its statusword 6041h reads as {value:?}", node.raw()),
    };
    let position = match bus.read(node, &objects::POSITION_ACTUAL)? {
        Value::Integer32(position) => position,
        value => anyhow::bail!("node {}: its position 6064h reads as {value:?}", node.raw()),
    };
    let marker = match &encoder.power_marker {
        Some(marker) => Some(read_marker(&mut bus, node, marker)?),
        None => None,
    };
    Ok(Shown { vendor, product, serial, statusword, position, marker })
}

/// Writes the marker of `encoder`, if it has one, and reads it back.
///
/// # Errors
/// If the drive refuses it, or does not keep it.
pub fn mark<L: Link, C: Clock>(link: &mut L, clock: &C, node: NodeId, encoder: &Encoder) -> anyhow::Result<()>
where
    L::Error: Send + Sync + 'static,
{
    let Some(marker) = &encoder.power_marker else { return Ok(()) };
    let mut bus = Bystander::new(link, clock, PATIENCE, |_| {});
    let Some(value) = marker.as_value() else { anyhow::bail!("power_marker: {marker:?} does not fit its type") };
    bus.write(node, address(marker), value)?;
    let found = read_marker(&mut bus, node, marker)?;
    anyhow::ensure!(
        found == value,
        "node {}: the power marker was written as {value:?} and reads {found:?}",
        node.raw()
    );
    Ok(())
}

const fn address(marker: &ObjectWrite) -> Address {
    Address::new(marker.index, marker.subindex)
}

fn read_marker<L: Link, C: Clock, O: FnMut(&Received)>(
    bus: &mut Bystander<'_, L, C, O>,
    node: NodeId,
    marker: &ObjectWrite,
) -> Result<Value, SdoError<L::Error>> {
    let data_type = marker.kind.data_type();
    sdo::read(bus, PATIENCE, node, address(marker), data_type)
}

/// A number that a drive need not have.
fn number<L: Link, C: Clock, O: FnMut(&Received)>(
    bus: &mut Bystander<'_, L, C, O>,
    node: NodeId,
    object: &Object,
) -> Result<Option<u32>, SdoError<L::Error>> {
    Ok(match bus.read_optional(node, object)? {
        Some(Value::Unsigned32(value)) => Some(value),
        _ => None,
    })
}

//! Node ids on command lines.

use uarm_io::drive::NodeId;
use uarm_io::drive::wire::MASTER_NODE;

/// Reads the node id of a drive.
///
/// # Errors
/// Unless it is 1 to 126: 127 is the master's.
pub fn node_id(text: &str) -> Result<NodeId, String> {
    let expected = || format!("expected a node id, 1 to {}", MASTER_NODE - 1);
    let raw: u8 = text.parse().map_err(|_| expected())?;
    NodeId::new(raw).ok().filter(|node| (1..MASTER_NODE).contains(&node.raw())).ok_or_else(expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_have_1_to_126() {
        assert_eq!(node_id("126").map(NodeId::raw), Ok(126));
        for text in ["0", "127", "-1", "two", "300"] {
            assert!(node_id(text).unwrap_err().contains("1 to 126"), "{text}");
        }
    }
}

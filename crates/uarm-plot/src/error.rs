//! What can go wrong.

use std::path::PathBuf;

/// A figure that could not be drawn or written.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The drawing library refused; its message.
    #[error("drawing: {0}")]
    Drawing(String),
    /// The PNG encoder refused.
    #[error("PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// The file's name does not say what it is.
    #[error("{}: expected a name that ends with .svg or .png", file.display())]
    Extension {
        /// The file.
        file: PathBuf,
    },
    /// The file cannot be written.
    #[error("{}: {source}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
}

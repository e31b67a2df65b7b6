//! Figures: the paper's, and those of the training, as SVG and PNG.
//!
//! Drawing is deterministic: the font comes with the program, nothing of the system takes part, and the same data give
//! the same bytes.
//!
//! | module | subject |
//! |---|---|
//! | [`sheet`] | what a figure shows: panels, axes, curves, legend |
//! | [`style`] | colours, dashes, line widths |
//! | [`draw`] | a sheet on any `plotters` backend |
//! | [`polyline`] | clipping and dashing |
//! | [`raster`], [`text`] | the backend behind PNG files |
//! | [`output`] | files |
//! | [`experiments`] | the runs whose motion is shown |
//! | [`paper`] | Figs. 4 to 11 and 13 to 16 |
//! | [`overview`] | the six controllers in one figure |
//! | [`sets`] | Fig. 12, and how its sets were learned |

pub mod draw;
pub mod experiments;
pub mod output;
pub mod overview;
pub mod paper;
pub mod polyline;
pub mod raster;
pub mod sets;
pub mod sheet;
pub mod style;
pub mod text;

/// A figure that could not be drawn or written.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The drawing library refused.
    #[error("drawing: {0}")]
    Drawing(String),
    /// The PNG encoder refused.
    #[error("PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// The file's name does not say what it is.
    #[error("{}: expected a name that ends with .svg or .png", file.display())]
    Extension {
        /// The file.
        file: std::path::PathBuf,
    },
    /// The file cannot be written.
    #[error("{}: {source}", file.display())]
    Write {
        /// The file.
        file: std::path::PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

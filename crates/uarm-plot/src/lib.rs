//! Line charts as SVG and PNG files.
//!
//! ```
//! use uarm_plot::output::{png, svg};
//! use uarm_plot::sheet::{Axis, Panel, Sheet, legend};
//! use uarm_plot::style::{BLUE, Stroke};
//!
//! let decay = (0..=300).map(|k| 0.01 * f64::from(k)).map(|time| [time, (-time).exp()]);
//! let line = Stroke::solid(BLUE);
//! let panel = Panel::new("", Axis::new("Time (s)", 0.0..3.0, 0.5, 1), Axis::new("Error (\u{b0})", 0.0..1.0, 0.2, 1));
//! let sheet = Sheet {
//!     name: "decay".into(),
//!     title: "An error that decays".into(),
//!     note: "one time constant a second".into(),
//!     size: [620, 430],
//!     columns: 1,
//!     legend: legend(&[("error", line)]),
//!     panels: vec![panel.with(line, decay)],
//! };
//! assert!(svg(&sheet)?.contains("An error that decays"));
//! assert!(png(&sheet)?.starts_with(b"\x89PNG"));
//! # Ok::<(), uarm_plot::error::FigureError>(())
//! ```
//!
//! Drawing is deterministic: the font comes with the crate, nothing of the system takes part, and the same data give the
//! same bytes.
//!
//! | module | subject |
//! |---|---|
//! | [`sheet`] | what a figure shows: panels, axes, curves, legend |
//! | [`envelope`] | a long curve in bounded memory |
//! | [`style`] | colours, dashes, line widths |
//! | [`output`] | SVG and PNG documents and files |
//! | [`error`] | what can go wrong |
#![forbid(unsafe_code)]

mod draw;
pub mod envelope;
pub mod error;
pub mod output;
mod polyline;
mod raster;
pub mod sheet;
pub mod style;
mod text;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

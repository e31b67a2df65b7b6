//! Figures as files: which formats the commands offer.

use std::path::{Path, PathBuf};

use uarm_plot::error::FigureError;
use uarm_plot::output::{self, FileFormat};
use uarm_plot::sheet::Sheet;

/// Kinds of files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Vectors: for print and the web
    Svg,
    /// Pixels: for slides and previews
    Png,
    /// Both
    #[default]
    Both,
}

impl Format {
    const fn files(self) -> &'static [FileFormat] {
        match self {
            Self::Svg => &[FileFormat::Svg],
            Self::Png => &[FileFormat::Png],
            Self::Both => &FileFormat::ALL,
        }
    }
}

/// Writes the sheet's files into `directory` and returns their paths.
///
/// # Errors
/// If it cannot be drawn, or a file not be written.
pub fn write(sheet: &Sheet, directory: &Path, format: Format) -> Result<Vec<PathBuf>, FigureError> {
    output::write(sheet, directory, format.files())
}

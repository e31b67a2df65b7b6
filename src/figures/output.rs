//! Figures as files: which formats the commands offer.

use std::path::{Path, PathBuf};

use anyhow::Context;
use uarm_plot::output::{self, FileFormat};
use uarm_plot::sheet::Sheet;

use crate::output_files::OutputFiles;

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

/// Writes the files of all sheets into `directory`, which is made if it is not there, and returns their paths. Nothing is
/// written if one of them could not be.
///
/// # Errors
/// If a sheet cannot be drawn, or a file not be written.
pub fn write(
    sheets: &[Sheet],
    directory: &Path,
    format: Format,
    outputs: &OutputFiles,
) -> anyhow::Result<Vec<PathBuf>> {
    let files = |sheet| output::files(sheet, directory, format.files());
    std::fs::create_dir_all(directory).with_context(|| directory.display().to_string())?;
    let all: Vec<_> = sheets.iter().flat_map(|sheet| files(sheet).map(move |file| (sheet, file))).collect();
    outputs.check(all.iter().map(|(_, file)| file.path()))?;
    for (sheet, file) in &all {
        let bytes = file.render(sheet)?;
        outputs.write(file.path(), |output| output.write_all(&bytes))?;
    }
    Ok(all.into_iter().map(|(_, file)| file.path().to_owned()).collect())
}

//! Sheets as files.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use plotters::backend::SVGBackend;

use crate::draw::{UNITS_PER_POINT, draw};
use crate::error::FigureError;
use crate::raster::{Canvas, Raster};
use crate::sheet::Sheet;
use crate::text::Faces;

/// A pixel of a PNG file is the mean of so many units by so many: two pixels a point, for sharp text on any screen.
const UNITS_PER_PIXEL: u32 = 2;

/// How a figure is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// Vectors, in a file `*.svg`.
    Svg,
    /// Pixels, two a point, in a file `*.png`.
    Png,
}

impl FileFormat {
    /// All formats.
    pub const ALL: [Self; 2] = [Self::Svg, Self::Png];

    const fn extension(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Png => "png",
        }
    }
}

/// The file of one figure, in the format that its name says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FigureFile {
    path: PathBuf,
    format: FileFormat,
}

impl FromStr for FigureFile {
    type Err = FigureError;

    fn from_str(text: &str) -> Result<Self, FigureError> {
        Self::new(text.into())
    }
}

impl FigureFile {
    /// The file at `path`.
    ///
    /// # Errors
    /// [`FigureError::Extension`] if its name ends with neither `.svg` nor `.png`.
    pub fn new(path: PathBuf) -> Result<Self, FigureError> {
        let is = |format: &FileFormat| path.extension().is_some_and(|extension| extension == format.extension());
        match FileFormat::ALL.into_iter().find(is) {
            Some(format) => Ok(Self { path, format }),
            None => Err(FigureError::Extension { file: path }),
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is to stand in it.
    ///
    /// # Errors
    /// If the sheet cannot be drawn.
    pub fn render(&self, sheet: &Sheet) -> Result<Vec<u8>, FigureError> {
        match self.format {
            FileFormat::Svg => svg(sheet).map(String::into_bytes),
            FileFormat::Png => png(sheet),
        }
    }

    /// Writes the sheet over whatever is there.
    ///
    /// # Errors
    /// If it cannot be drawn, or the file not be written.
    pub fn write(&self, sheet: &Sheet) -> Result<(), FigureError> {
        let bytes = self.render(sheet)?;
        std::fs::write(&self.path, bytes).map_err(|source| FigureError::Write { file: self.path.clone(), source })
    }
}

/// The sheet as an SVG document.
///
/// # Errors
/// If it cannot be drawn.
pub fn svg(sheet: &Sheet) -> Result<String, FigureError> {
    let [width, height] = sheet.size.map(|points| points * UNITS_PER_POINT);
    let mut document = String::new();
    draw(sheet, &Faces::load()?, SVGBackend::with_string(&mut document, (width, height)))?;
    // Shown in points, drawn in units: `plotters` knows one size only, and no joints.
    let [shown_width, shown_height] = sheet.size;
    // XML has no way to write these.
    let document = document.replace(|letter: char| letter.is_control() && !letter.is_ascii_whitespace(), "\u{FFFD}");
    Ok(document.replacen(
        &format!("<svg width=\"{width}\" height=\"{height}\""),
        &format!(
            "<svg width=\"{shown_width}\" height=\"{shown_height}\" stroke-linecap=\"round\" stroke-linejoin=\"round\""
        ),
        1,
    ))
}

/// The sheet as a PNG file.
///
/// # Errors
/// If it cannot be drawn.
pub fn png(sheet: &Sheet) -> Result<Vec<u8>, FigureError> {
    let faces = Faces::load()?;
    let mut canvas = Canvas::new(sheet.size.map(|points| points * UNITS_PER_POINT));
    draw(sheet, &faces, Raster::new(&mut canvas, &faces))?;
    canvas.png(UNITS_PER_PIXEL)
}

/// Writes the sheet to `directory` in each of `formats`, under [`Sheet::name`], and returns the paths of the files.
///
/// # Errors
/// If it cannot be drawn, or a file not be written.
pub fn write(sheet: &Sheet, directory: &Path, formats: &[FileFormat]) -> Result<Vec<PathBuf>, FigureError> {
    let write = |file: FigureFile| {
        file.write(sheet)?;
        Ok(file.path)
    };
    files(sheet, directory, formats).map(write).collect()
}

/// The files of a sheet in `directory`, one for each of `formats`.
pub fn files(sheet: &Sheet, directory: &Path, formats: &[FileFormat]) -> impl Iterator<Item = FigureFile> {
    let file = |&format: &FileFormat| {
        let path = directory.join(format!("{}.{}", sheet.name, format.extension()));
        FigureFile { path, format }
    };
    formats.iter().map(file)
}

//! Sheets as files.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use plotters::backend::SVGBackend;

use super::FigureError;
use super::draw::{UNITS_PER_POINT, draw};
use super::raster::{Canvas, Raster};
use super::sheet::Sheet;
use super::text::Faces;

/// A pixel of a PNG file is the mean of so many units by so many: two pixels a point, for sharp text on any screen.
const UNITS_PER_PIXEL: u32 = 2;

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

/// A file with one figure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FigureFile {
    path: PathBuf,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Svg,
    Png,
}

impl Kind {
    const ALL: [Self; 2] = [Self::Svg, Self::Png];

    const fn extension(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Png => "png",
        }
    }
}

impl Format {
    const fn kinds(self) -> &'static [Kind] {
        match self {
            Self::Svg => &[Kind::Svg],
            Self::Png => &[Kind::Png],
            Self::Both => &Kind::ALL,
        }
    }
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
    /// [`FigureError::Extension`] if its name does not say of which kind it is.
    pub fn new(path: PathBuf) -> Result<Self, FigureError> {
        let is = |kind: &Kind| path.extension().is_some_and(|extension| extension == kind.extension());
        match Kind::ALL.into_iter().find(is) {
            Some(kind) => Ok(Self { path, kind }),
            None => Err(FigureError::Extension { file: path }),
        }
    }

    /// Writes the sheet.
    ///
    /// # Errors
    /// If it cannot be drawn, or the file not be written.
    pub fn write(&self, sheet: &Sheet) -> Result<(), FigureError> {
        let bytes = match self.kind {
            Kind::Svg => svg(sheet)?.into_bytes(),
            Kind::Png => png(sheet)?,
        };
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

/// Writes the sheet's files into `directory` and returns their paths.
///
/// # Errors
/// If it cannot be drawn, or a file not be written.
pub fn write(sheet: &Sheet, directory: &Path, format: Format) -> Result<Vec<PathBuf>, FigureError> {
    let mut written = Vec::new();
    for &kind in format.kinds() {
        let file = FigureFile { path: directory.join(format!("{}.{}", sheet.name, kind.extension())), kind };
        file.write(sheet)?;
        written.push(file.path);
    }
    Ok(written)
}

/// Writes the sheet to `file`, as its extension says.
///
/// # Errors
/// If the extension is none of the formats, if it cannot be drawn, or the file not be written.
pub fn write_as(sheet: &Sheet, file: &Path) -> Result<(), FigureError> {
    FigureFile::new(file.to_owned())?.write(sheet)
}

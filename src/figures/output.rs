//! Sheets as files.

use std::path::{Path, PathBuf};

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
    let mut keep = |extension: &str, bytes: &[u8]| {
        let file = directory.join(format!("{}.{extension}", sheet.name));
        std::fs::write(&file, bytes).map_err(|source| FigureError::Write { file: file.clone(), source })?;
        written.push(file);
        Ok::<(), FigureError>(())
    };
    if matches!(format, Format::Svg | Format::Both) {
        keep("svg", svg(sheet)?.as_bytes())?;
    }
    if matches!(format, Format::Png | Format::Both) {
        keep("png", &png(sheet)?)?;
    }
    Ok(written)
}

/// Writes the sheet to `file`, as its extension says.
///
/// # Errors
/// If the extension is none of the formats, if it cannot be drawn, or the file not be written.
pub fn write_as(sheet: &Sheet, file: &Path) -> Result<(), FigureError> {
    let bytes = match file.extension().and_then(|extension| extension.to_str()) {
        Some("svg") => svg(sheet)?.into_bytes(),
        Some("png") => png(sheet)?,
        _ => return Err(FigureError::Extension { file: file.to_owned() }),
    };
    std::fs::write(file, bytes).map_err(|source| FigureError::Write { file: file.to_owned(), source })
}

//! Text as grey values, in the font that the program carries.

use ab_glyph::{Font, FontRef, GlyphId, PxScale, ScaleFont, point};
use plotters::style::{FontStyle, register_font};

use crate::error::FigureError;

/// The font's name in SVG files, with what a viewer without it should use. PNG files carry its shapes.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";
/// `plotters` takes a size that is this many times the em, and writes the em into SVG files.
pub const SIZE_PER_EM: f64 = 1.24;

/// The two faces in use.
#[derive(Clone, Debug)]
pub struct Faces {
    regular: FontRef<'static>,
    bold: FontRef<'static>,
}

impl Faces {
    /// Reads the faces and makes them known to `plotters`.
    ///
    /// # Errors
    /// If they cannot be read: the program was built wrong.
    pub fn load() -> Result<Self, FigureError> {
        let unreadable = || FigureError::Drawing("the built-in font cannot be read".into());
        for (style, bytes) in [(FontStyle::Normal, dejavu::sans::regular()), (FontStyle::Bold, dejavu::sans::bold())] {
            register_font(FAMILY, style, bytes).map_err(|_| unreadable())?;
        }
        let face = |bytes| FontRef::try_from_slice(bytes).map_err(|_| unreadable());
        Ok(Self { regular: face(dejavu::sans::regular())?, bold: face(dejavu::sans::bold())? })
    }

    fn face(&self, bold: bool) -> &FontRef<'static> {
        if bold { &self.bold } else { &self.regular }
    }

    /// How long `text` is in units of the em.
    pub fn length(&self, text: &str, bold: bool) -> f32 {
        self.lay_out(text, bold).last().map_or(0.0, |(_, _, end)| end)
    }

    /// The grey values of `text` with its baseline's start at the origin, x to the right and y downwards, for an em of
    /// `em` pixels.
    pub fn rasterise(&self, text: &str, bold: bool, em: f32, mut put: impl FnMut(i32, i32, f32)) {
        let face = self.face(bold);
        let scale = PxScale::from(em * face.height_unscaled() / face.units_per_em().unwrap_or(1.0));
        for (glyph, start, _) in self.lay_out(text, bold) {
            let glyph = glyph.with_scale_and_position(scale, point(start * em, 0.0));
            let Some(outline) = face.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, grey| put(x as i32 + corner.x as i32, y as i32 + corner.y as i32, grey));
        }
    }

    /// Each glyph with where it starts and ends, in units of the em.
    fn lay_out<'a>(
        &'a self,
        text: &'a str,
        bold: bool,
    ) -> impl DoubleEndedIterator<Item = (GlyphId, f32, f32)> + use<'a> {
        let face = self.face(bold);
        let scaled = face.as_scaled(face.height_unscaled());
        let per_em = face.units_per_em().unwrap_or(1.0);
        let mut position = 0.0;
        let mut previous = None;
        let glyphs: Vec<_> = text
            .chars()
            .map(|letter| {
                let glyph = face.glyph_id(letter);
                let kerning = previous.map_or(0.0, |previous| scaled.kern(previous, glyph));
                previous = Some(glyph);
                let start = position + kerning / per_em;
                position = start + scaled.h_advance(glyph) / per_em;
                (glyph, start, position)
            })
            .collect();
        glyphs.into_iter()
    }
}

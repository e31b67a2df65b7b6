//! The `plotters` backend behind PNG files. Lines are drawn as the set of pixels near them, with round ends and joints:
//! the polygons that `plotters` makes of wide lines break on noisy curves. Drawn large, then averaged down.

use std::convert::Infallible;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontStyle,
};

use crate::error::FigureError;
use crate::polyline::distance;
use crate::text::{Faces, SIZE_PER_EM};

/// Height of a small x over the em in DejaVu Sans: SVG's ex, in which its files place text.
const X_HEIGHT: f32 = 0.547;
/// Where SVG files of `plotters` put the baseline of text that hangs below its anchor, in units of the em.
const HANGING_BASELINE: f32 = 0.76;

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// A picture in the making.
#[derive(Debug)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Canvas {
    /// A white picture.
    pub fn new([width, height]: [u32; 2]) -> Self {
        let (width, height) = (width as usize, height as usize);
        Self { width, height, pixels: vec![[0xFF; 3]; width * height] }
    }

    /// The picture as a PNG file, reduced: each of its pixels is the mean of `reduction` by `reduction`.
    ///
    /// # Errors
    /// If the encoder fails.
    pub fn png(&self, reduction: u32) -> Result<Vec<u8>, FigureError> {
        let step = reduction as usize;
        let (width, height) = (self.width / step, self.height / step);
        let count = u32::from(u16::try_from(step * step).unwrap_or(u16::MAX));
        let mut reduced = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            for x in 0..width {
                for channel in 0..3 {
                    let block = (0..step * step).map(|k| {
                        let index = (y * step + k / step) * self.width + x * step + k % step;
                        u32::from(self.pixels[index][channel])
                    });
                    reduced.push(((block.sum::<u32>() + count / 2) / count) as u8);
                }
            }
        }
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        encoder.write_header()?.write_image_data(&reduced)?;
        Ok(file)
    }

    fn blend(&mut self, x: i32, y: i32, colour: BackendColor, coverage: f64) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x >= self.width || y >= self.height {
            return;
        }
        let alpha = (colour.alpha * coverage).clamp(0.0, 1.0);
        let (red, green, blue) = colour.rgb;
        for (channel, value) in self.pixels[y * self.width + x].iter_mut().zip([red, green, blue]) {
            *channel = (f64::from(*channel) * (1.0 - alpha) + f64::from(value) * alpha).round() as u8;
        }
    }

    /// All pixels within half a `width` of the line between two points; the border pixels by how much they are covered.
    fn stroke(&mut self, from: BackendCoord, to: BackendCoord, width: u32, colour: BackendColor) {
        let radius = f64::from(width) / 2.0;
        let reach = radius.ceil() as i32 + 1;
        let ends = [from, to].map(|(x, y)| [f64::from(x), f64::from(y)]);
        for y in from.1.min(to.1) - reach..=from.1.max(to.1) + reach {
            for x in from.0.min(to.0) - reach..=from.0.max(to.0) + reach {
                let coverage = radius + 0.5 - distance([f64::from(x), f64::from(y)], ends[0], ends[1]);
                if coverage > 0.0 {
                    self.blend(x, y, colour, coverage.min(1.0));
                }
            }
        }
    }
}

/// Draws on a canvas.
#[derive(Debug)]
pub struct Raster<'a> {
    canvas: &'a mut Canvas,
    faces: &'a Faces,
}

impl<'a> Raster<'a> {
    /// Draws on `canvas` and writes with `faces`.
    pub const fn new(canvas: &'a mut Canvas, faces: &'a Faces) -> Self {
        Self { canvas, faces }
    }
}

impl DrawingBackend for Raster<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.canvas.width as u32, self.canvas.height as u32)
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        self.canvas.blend(x, y, colour, 1.0);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.canvas.stroke(from, to, style.stroke_width(), style.color());
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn {
        let mut points = path.into_iter();
        let Some(mut from) = points.next() else { return Ok(()) };
        for to in points {
            self.canvas.stroke(from, to, style.stroke_width(), style.color());
            from = to;
        }
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        if !fill {
            let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
            return self.draw_path(corners, style);
        }
        for y in top.min(bottom)..=top.max(bottom) {
            for x in left.min(right)..=left.max(right) {
                self.canvas.blend(x, y, style.color(), 1.0);
            }
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, centre: BackendCoord, radius: u32, style: &S, _fill: bool) -> Drawn {
        self.canvas.stroke(centre, centre, 2 * radius, style.color());
        Ok(())
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, (x, y): BackendCoord) -> Drawn {
        let em = (style.size() / SIZE_PER_EM) as f32;
        let bold = matches!(style.style(), FontStyle::Bold);
        let faces = self.faces;
        let start = -em
            * faces.length(text, bold)
            * match style.anchor().h_pos {
                HPos::Left => 0.0,
                HPos::Center => 0.5,
                HPos::Right => 1.0,
            };
        let baseline = em
            * match style.anchor().v_pos {
                VPos::Top => HANGING_BASELINE,
                VPos::Center => 0.5 * X_HEIGHT,
                VPos::Bottom => -0.5 * X_HEIGHT,
            };
        let (colour, transform) = (style.color(), style.transform());
        let (start, baseline) = (start.round() as i32, baseline.round() as i32);
        faces.rasterise(text, bold, em, |right, down, grey| {
            let (dx, dy) = transform.transform(start + right, baseline + down);
            self.canvas.blend(x + dx, y + dy, colour, f64::from(grey));
        });
        Ok(())
    }
}

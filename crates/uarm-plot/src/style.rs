//! How curves look. Colours are the palette of Okabe and Ito (2008), which people with any colour vision tell apart;
//! dashes repeat the distinction.

/// A colour: red, green and blue in sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

/// Black, as axes and text are.
pub const BLACK: Colour = Colour(0x20, 0x20, 0x20);
/// Grey, for what is in the background.
pub const GREY: Colour = Colour(0x80, 0x80, 0x80);
/// Orange of the palette.
pub const ORANGE: Colour = Colour(0xE6, 0x9F, 0x00);
/// Sky blue of the palette.
pub const SKY_BLUE: Colour = Colour(0x56, 0xB4, 0xE9);
/// Bluish green of the palette.
pub const GREEN: Colour = Colour(0x00, 0x9E, 0x73);
/// Blue of the palette.
pub const BLUE: Colour = Colour(0x00, 0x72, 0xB2);
/// Vermilion of the palette.
pub const VERMILION: Colour = Colour(0xD5, 0x5E, 0x00);
/// Reddish purple of the palette.
pub const PURPLE: Colour = Colour(0xCC, 0x79, 0xA7);

/// How a line is interrupted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dash {
    /// An uninterrupted line.
    #[default]
    Solid,
    /// Dashes only.
    Dashed,
    /// Dots only.
    Dotted,
    /// Dashes and dots alternate.
    DashDot,
}

impl Dash {
    /// Lengths that are drawn and left out in turn, points; empty for a solid line. Lines have round ends, which lengthen
    /// what is drawn by their width.
    pub const fn pattern(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[6.0, 4.5],
            Self::Dotted => &[0.6, 3.6],
            Self::DashDot => &[7.5, 3.6, 0.6, 3.6],
        }
    }
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// The colour of the line.
    pub colour: Colour,
    /// The width of the line, points; above 0.
    pub width: f64,
    /// How the line is interrupted.
    pub dash: Dash,
}

impl Stroke {
    /// A solid line of 1.6 points.
    pub const fn solid(colour: Colour) -> Self {
        Self { colour, width: 1.6, dash: Dash::Solid }
    }

    /// The same line, interrupted.
    pub const fn dashed(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }

    /// The same line with another width, points.
    pub const fn wide(self, width: f64) -> Self {
        Self { width, ..self }
    }
}

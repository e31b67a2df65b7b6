//! How curves look. Colours are Okabe and Ito's, which people with any colour vision tell apart; dashes say it again.

use hinf_control::Law;
use plotters::style::RGBColor;

/// Black, of axes and text too.
pub const BLACK: RGBColor = RGBColor(0x20, 0x20, 0x20);
/// Grey, for what stands in the background.
pub const GREY: RGBColor = RGBColor(0x80, 0x80, 0x80);
/// Orange of the palette.
pub const ORANGE: RGBColor = RGBColor(0xE6, 0x9F, 0x00);
/// Sky blue of the palette.
pub const SKY_BLUE: RGBColor = RGBColor(0x56, 0xB4, 0xE9);
/// Bluish green of the palette.
pub const GREEN: RGBColor = RGBColor(0x00, 0x9E, 0x73);
/// Blue of the palette.
pub const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xB2);
/// Vermilion of the palette.
pub const VERMILION: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
/// Reddish purple of the palette.
pub const PURPLE: RGBColor = RGBColor(0xCC, 0x79, 0xA7);

/// How a line is interrupted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dash {
    /// Not at all.
    #[default]
    Solid,
    /// Dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dashes and dots in turn.
    DashDot,
}

impl Dash {
    /// Lengths drawn and left out in turn, points; empty for a solid line. Lines have round ends, which lengthen what is
    /// drawn by their width.
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
    /// Its colour.
    pub colour: RGBColor,
    /// Its width, points.
    pub width: f64,
    /// Its dashes.
    pub dash: Dash,
}

impl Stroke {
    /// A solid line of common width.
    pub const fn solid(colour: RGBColor) -> Self {
        Self { colour, width: 1.6, dash: Dash::Solid }
    }

    /// The same with dashes.
    pub const fn dashed(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }

    /// The same with another width, points.
    pub const fn wide(self, width: f64) -> Self {
        Self { width, ..self }
    }
}

/// The base.
pub const BASE: Stroke = Stroke::solid(GREEN).dashed(Dash::DashDot);
/// Joint 2.
pub const JOINT_2: Stroke = Stroke::solid(BLUE);
/// Joint 3.
pub const JOINT_3: Stroke = Stroke::solid(VERMILION).dashed(Dash::Dashed);
/// The desired motion.
pub const REFERENCE: Stroke = Stroke::solid(BLACK).dashed(Dash::Dotted).wide(1.2);

/// What was recorded, beside what a replay makes of it.
pub const RECORDED: Stroke = Stroke::solid(BLACK);
/// What a replay makes of a record.
pub const REPLAYED: Stroke = Stroke::solid(VERMILION).dashed(Dash::Dashed);

/// A law among the others.
pub const fn of_law(law: Law) -> Stroke {
    match law {
        Law::Nonlinear => Stroke::solid(BLACK),
        Law::Adaptive => Stroke::solid(ORANGE),
        Law::Neural => Stroke::solid(SKY_BLUE),
        Law::NeuralModel => Stroke::solid(BLUE).dashed(Dash::Dashed),
        Law::Fuzzy => Stroke::solid(PURPLE),
        Law::FuzzyModel => Stroke::solid(VERMILION).dashed(Dash::Dashed),
        Law::ComputedTorque => Stroke::solid(GREEN).dashed(Dash::DashDot),
    }
}

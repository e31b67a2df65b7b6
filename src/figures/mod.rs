//! Figures: the paper's, and those of the training, as SVG and PNG. [`uarm_plot`] draws them.
//!
//! | module | subject |
//! |---|---|
//! | [`style`] | how the curves of each signal and law look |
//! | [`output`] | files |
//! | [`experiments`] | the runs whose motion is shown |
//! | [`paper`] | Figs. 4 to 11 and 13 to 16 |
//! | [`overview`] | the six controllers in one figure |
//! | [`sets`] | Fig. 12, and how its sets were learned |

pub mod experiments;
pub mod output;
pub mod overview;
pub mod paper;
pub mod sets;
pub mod style;

//! The subcommands, a file or folder each, with `Arguments` and `execute`. What two of them share stands above this folder.

pub mod campaign;
pub mod check;
pub mod compare;
pub mod completions;
pub mod doctor;
pub mod drive;
pub mod explain;
pub mod figures;
pub mod filters;
pub mod identify;
pub mod man;
pub mod map;
pub mod monitor;
pub mod plant;
pub mod replay;
pub mod run;
pub mod show;
pub mod stability;
pub mod train;

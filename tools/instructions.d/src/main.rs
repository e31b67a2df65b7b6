//! What `tools/instructions` counts: each case does one thing once, between the marks that callgrind is told of.
//!
//! By itself the program only names the cases, in the order in which they ran.

mod laws;
mod model;
mod robot;

use std::error::Error;
use std::hint::black_box;

/// Runs a case. What comes before, in the caller, is not counted: callgrind counts within this function alone.
#[inline(never)]
fn counted<R>(case: &str, work: impl FnOnce() -> R) {
    black_box(work());
    black_box(case);
}

/// Names a case, and counts it.
fn case<R>(name: &str, work: impl FnOnce() -> R) {
    println!("{name}");
    counted(name, work);
}

fn main() -> Result<(), Box<dyn Error>> {
    laws::run::<f64>("f64")?;
    laws::run::<f32>("f32")?;
    model::run::<f64>("f64");
    model::run::<f32>("f32");
    robot::run()
}

//! Proof that the crates below build without the standard library.
//!
//! This program brings its own panic handler. A crate that pulls in `std`, itself or through a dependency, brings
//! `std`'s, and `cargo check` fails with a duplicate lang item `panic_impl` that names the culprit.
#![no_std]
#![no_main]

use core::panic::PanicInfo;

use dem_model as _;
use hinf_control as _;
use uarm_io as _;

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    loop {}
}

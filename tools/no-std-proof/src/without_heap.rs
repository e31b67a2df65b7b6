//! Proof that the crates below build without the standard library, and without a heap.
//!
//! This program brings its own panic handler. A crate that pulls in `std`, itself or through a dependency, brings
//! `std`'s, and `cargo check` fails with a duplicate lang item `panic_impl` that names the culprit. It brings no
//! allocator: a crate that pulls in `alloc` fails as well.
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

//! Proof that `uarm-sim` builds without the standard library, given a heap. See `without_heap.rs` for how it is proved.
#![no_std]
#![no_main]

use core::alloc::{GlobalAlloc, Layout};
use core::panic::PanicInfo;

use uarm_sim as _;

/// A heap without memory: the program is never run.
struct NoMemory;

// SAFETY: each allocation fails, which the contract allows, so that no pointer is ever handed back.
unsafe impl GlobalAlloc for NoMemory {
    unsafe fn alloc(&self, _layout: Layout) -> *mut u8 {
        core::ptr::null_mut()
    }

    unsafe fn dealloc(&self, _pointer: *mut u8, _layout: Layout) {}
}

#[global_allocator]
static HEAP: NoMemory = NoMemory;

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    loop {}
}

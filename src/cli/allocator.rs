//! Allocator of the program: memory that the system refuses ends the program with an error and its
//! exit code, where Rust would abort.

use std::alloc::{GlobalAlloc, Layout, System};

use crate::memory;

/// The system's allocator. Memory that it refuses ends the program with E501.
///
/// A program sets it as its `#[global_allocator]`. Before a command line runs, refusals are handed
/// to the caller, as those of the system's allocator are.
#[derive(Debug, Clone, Copy, Default)]
pub struct Allocator;

/// Returns a block that was given, and ends the program if it was refused.
fn given(block: *mut u8, bytes: usize) -> *mut u8 {
    if block.is_null() {
        memory::refused(bytes);
    }
    block
}

// SAFETY: all blocks are the system's, handed on as they are.
#[expect(unsafe_code, reason = "the trait is unsafe")]
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promised.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promised.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as the caller promised.
        given(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(block, layout) }
    }
}

/// Sets how the system's allocator keeps memory that is freed.
///
/// Where address space is limited, all threads share one heap. A heap for each would take 64 MiB of
/// it, or none where there is little, so that more address space could be less.
///
/// Large blocks go back to the system at once. By default the size from which they do grows with
/// the largest block that was freed, and a run keeps up to twice that.
pub(super) fn set_up() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// Smallest block that has pages of its own, and free memory that is kept \[bytes\].
        const OWN_PAGES: libc::c_int = 4 << 20;
        let is_limited = memory::address_space().is_some();
        // SAFETY: no thread but this one runs yet.
        #[expect(unsafe_code, reason = "a function of C")]
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, OWN_PAGES);
            libc::mallopt(libc::M_TRIM_THRESHOLD, OWN_PAGES);
            if is_limited {
                libc::mallopt(libc::M_ARENA_MAX, 1);
            }
        }
    }
}

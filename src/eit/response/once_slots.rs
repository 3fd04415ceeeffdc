//! Equal slices of one block, each written once, when it is first asked for.
//!
//! The block is reserved at the start, but the system gives memory only to the pages that are written. So a frame allocates nothing
//! on the heap, and slices that nobody asks for cost nothing.
//!
//! Invariant: a slice is written by one thread before anybody sees it, and never again.

#![allow(
    unsafe_code,
    reason = "a shared block whose parts are written once is not possible without"
)]

use std::cell::UnsafeCell;
use std::fmt;
use std::sync::OnceLock;

/// Slices of values, made on demand.
pub(super) struct OnceSlots {
    /// Slots x stride.
    values: Box<[UnsafeCell<f32>]>,
    /// Whether each slot is written.
    written: Box<[OnceLock<()>]>,
    /// Values per slot.
    stride: usize,
}

// SAFETY: a value is written only within the initialisation of its slot's `OnceLock`, which one thread does, and is read only after
// that, which happens after the write for every thread (`OnceLock::get_or_init`).
unsafe impl Sync for OnceSlots {}

impl OnceSlots {
    /// So many slots of so many values.
    pub(super) fn new(slots: usize, stride: usize) -> Self {
        let values = Box::into_raw(vec![0.0f32; slots * stride].into_boxed_slice());
        // SAFETY: the pointer is that of a box, given up above, and `UnsafeCell<f32>` has the layout of `f32`.
        let values = unsafe { Box::from_raw(values as *mut [UnsafeCell<f32>]) };
        Self {
            values,
            written: (0..slots).map(|_| OnceLock::new()).collect(),
            stride,
        }
    }

    /// Number of slots.
    pub(super) fn len(&self) -> usize {
        self.written.len()
    }

    /// The slice of a slot. The first time, `write` fills it: it must set every value, and must not ask for the same slot.
    ///
    /// # Panics
    /// If there is no such slot.
    pub(super) fn get_or_write(&self, slot: usize, write: impl FnOnce(&mut [f32])) -> &[f32] {
        let cells = &self.values[slot * self.stride..][..self.stride];
        let (first, count) = (UnsafeCell::raw_get(cells.as_ptr()), cells.len());
        self.written[slot].get_or_init(|| {
            // SAFETY: the slice lies within the block, and nothing else refers to it: it is handed out only below, after this
            // initialisation, which runs at most once to its end. If `write` panics, no reference is left.
            write(unsafe { std::slice::from_raw_parts_mut(first, count) });
        });
        // SAFETY: the slice lies within the block, is initialised, and is not written again.
        unsafe { std::slice::from_raw_parts(first, count) }
    }
}

impl Clone for OnceSlots {
    /// The same slots, none of them written yet.
    fn clone(&self) -> Self {
        Self::new(self.len(), self.stride)
    }
}

impl fmt::Debug for OnceSlots {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let written = self.written.iter().filter(|slot| slot.get().is_some());
        write!(f, "{} of {} slots written", written.count(), self.len())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn a_slot_is_written_once_whoever_asks() {
        let (slots, writes) = (OnceSlots::new(50, 3), AtomicUsize::new(0));
        let read = || {
            (0..50).for_each(|slot| {
                let values = slots.get_or_write(slot, |values| {
                    writes.fetch_add(1, Ordering::Relaxed);
                    values.fill(slot as f32);
                });
                assert_eq!(values, [slot as f32; 3]);
            });
        };
        std::thread::scope(|scope| {
            (0..4).for_each(|_| {
                scope.spawn(read);
            });
        });
        assert_eq!(writes.into_inner(), 50);
        assert_eq!(format!("{slots:?}"), "50 of 50 slots written");
        assert_eq!(format!("{:?}", slots.clone()), "0 of 50 slots written");
    }

    #[test]
    fn a_write_that_panics_leaves_the_slot_to_the_next() {
        let slots = OnceSlots::new(1, 1);
        let panicked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            slots.get_or_write(0, |_| panic!("on purpose"));
        }));
        assert!(panicked.is_err());
        assert_eq!(slots.get_or_write(0, |values| values[0] = 2.0), [2.0]);
    }
}

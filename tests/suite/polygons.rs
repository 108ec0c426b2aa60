//! Footprints: whatever polygon comes in, its pieces cover it exactly; whatever ring comes in, nothing panics.

//! Exports of the engine to a page: bytes and questions go in, answers and pictures lie in memory.
//!
//! The caller writes bytes at the address that [`input`] returns, and calls [`open`] or [`ask`].
//! Both return 0, or 1 after a failure. They leave text at the address of [`answer`]: JSON, or the
//! error. The next call may move everything.

#![allow(unsafe_code, reason = "functions are exported by name, which counts as unsafe; there is no unsafe block")]

use std::cell::RefCell;

use serde_json::Value;

use crate::Engine;

/// State between one call and the next.
#[derive(Default)]
struct Held {
    input: Vec<u8>,
    engine: Option<Engine>,
    backdrop: Vec<u8>,
    answer: String,
}

thread_local! {
    static HELD: RefCell<Held> = RefCell::default();
}

impl Held {
    fn open(&mut self) -> Result<Value, String> {
        let engine = Engine::open(&std::mem::take(&mut self.input)).map_err(|e| e.to_string())?;
        self.backdrop = engine.backdrop();
        let opened = serde_json::to_value(engine.opened()).map_err(|e| e.to_string());
        self.engine = Some(engine);
        opened
    }

    fn ask(&mut self) -> Result<Value, String> {
        let question = serde_json::from_slice(&self.input).map_err(|e| e.to_string())?;
        self.engine.as_mut().ok_or("no scene is open")?.answer(question)
    }

    /// Keeps the text of a call for [`answer`], and returns the call's code.
    fn code_of(&mut self, done: Result<Value, String>) -> u32 {
        let code = u32::from(done.is_err());
        self.answer = done.map_or_else(|words| words, |value| value.to_string());
        code
    }
}

/// Returns the address of room for `n_bytes` bytes of input.
#[unsafe(no_mangle)]
pub extern "C" fn input(n_bytes: usize) -> *mut u8 {
    HELD.with_borrow_mut(|held| {
        held.input = vec![0; n_bytes];
        held.input.as_mut_ptr()
    })
}

/// Builds the scene from the packed bytes of the input.
#[unsafe(no_mangle)]
pub extern "C" fn open() -> u32 {
    HELD.with_borrow_mut(|held| {
        let done = held.open();
        held.code_of(done)
    })
}

/// Answers the question in the input, which is JSON.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> u32 {
    HELD.with_borrow_mut(|held| {
        let done = held.ask();
        held.code_of(done)
    })
}

/// Returns the address of the text of the last call (UTF-8).
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    HELD.with_borrow(|held| held.answer.as_ptr())
}

/// Returns the length of this text \[bytes\].
#[unsafe(no_mangle)]
pub extern "C" fn answer_length() -> usize {
    HELD.with_borrow(|held| held.answer.len())
}

/// Returns the address of the picture of the last question: a byte for each cell, north row first.
#[unsafe(no_mangle)]
pub extern "C" fn picture() -> *const u8 {
    HELD.with_borrow(|held| held.engine.as_ref().map_or(std::ptr::null(), |engine| engine.picture().as_ptr()))
}

/// Returns the length of the picture \[bytes\]; 0 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn picture_length() -> usize {
    HELD.with_borrow(|held| held.engine.as_ref().map_or(0, |engine| engine.picture().len()))
}

/// Returns the address of the backdrop of the mask, a byte for each cell.
#[unsafe(no_mangle)]
pub extern "C" fn backdrop() -> *const u8 {
    HELD.with_borrow(|held| held.backdrop.as_ptr())
}

/// Returns the length of the backdrop \[bytes\].
#[unsafe(no_mangle)]
pub extern "C" fn backdrop_length() -> usize {
    HELD.with_borrow(|held| held.backdrop.len())
}

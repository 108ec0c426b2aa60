//! Deflate for cells that come in long runs of few values, such as masks: matches are looked for where runs begin, not at
//! every byte.
//!
//! A match of LZ77 copies bytes from farther back. In a picture of runs it is runs that come again: those of the row above, or
//! of the last shadow of this form. So there are two kinds of copies. One repeats the byte before to the end of a run. The other
//! ends the run at hand as an earlier run of the same value ended, and goes on as that went on. To find such earlier runs each one
//! is filed under its value, its length and the length of the next.
//!
//! Over masks of cities this finds what zlib finds at its default level in half of the time; other bytes come back too, but hardly
//! smaller. Huffman codes and the frame of the stream are those of `libflate`.
//!
//! # References
//! RFC 1950 (zlib), RFC 1951 (deflate).

use std::io::Write;

use libflate::lz77::{Code, CompressionLevel, Lz77Encode, Sink};
use libflate::zlib::{EncodeOptions, Encoder};

/// Bytes that a match may have.
const LONGEST: usize = 258;
/// … and the fewest.
const SHORTEST: usize = 3;
/// How far back a match may begin \[bytes\].
const WINDOW: u16 = 1 << 15;
/// Earlier runs of the same length that are tried.
const TRIES: usize = 4;
/// Bits of the number that stands for the lengths of runs.
const KEY_BITS: u32 = 12;
/// No run.
const NONE: u32 = u32::MAX;

/// A zlib stream.
///
/// # Panics
/// With 4 GiB or more.
pub(super) fn deflate_runs(bytes: &[u8]) -> Vec<u8> {
    // All in one block: what it codes is alike throughout.
    let options = EncodeOptions::with_lz77(RunMatches).block_size(bytes.len() + 1);
    let mut encoder = Encoder::with_options(Vec::with_capacity(256), options).expect("a vector takes all");
    encoder.write_all(bytes).expect("a vector takes all");
    encoder.finish().into_result().expect("a vector takes all")
}

/// LZ77 at the beginnings of runs.
#[derive(Debug)]
struct RunMatches;

impl Lz77Encode for RunMatches {
    fn encode<S: Sink>(&mut self, bytes: &[u8], sink: S) {
        if !bytes.is_empty() {
            Parse::of(bytes).write(sink);
        }
    }

    fn flush<S: Sink>(&mut self, _: S) {}

    /// What a reader is told, and does not need.
    fn compression_level(&self) -> CompressionLevel {
        CompressionLevel::Balance
    }

    fn window_size(&self) -> u16 {
        WINDOW
    }
}

/// Bytes that are parsed.
struct Parse<'a> {
    bytes: &'a [u8],
    /// Where runs begin, and behind the last one its end, so often that any run has two behind it.
    starts: Vec<u32>,
    /// The last run with each key that was passed.
    last: Vec<u32>,
    /// For each run the one before it that has its key.
    before: Vec<u32>,
}

impl<'a> Parse<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        let starts = run_starts(bytes);
        let before = vec![NONE; starts.len()];
        Parse { bytes, starts, last: vec![NONE; 1 << KEY_BITS], before }
    }

    /// Writes all codes.
    fn write(&mut self, mut sink: impl Sink) {
        let n_runs = self.starts.len() - 3;
        let (mut at, mut run, mut distance) = (0, 0, 0);
        while at < self.bytes.len() {
            while self.start(run + 1) <= at {
                run += 1;
                self.enter(run);
            }
            let rest = self.start(run + 1) - at;
            let is_first = at == 0 || self.bytes[at - 1] != self.bytes[at];
            let (len, back) = if run + 1 < n_runs { self.longest(at, run, distance) } else { (0, 0) };
            // A match that ends within the run is no better than the run.
            let is_worth_it = len >= SHORTEST && (len > rest || is_first && len == rest);
            // Unless it is long, the one that begins behind the run may be longer.
            let is_next_longer = || run + 2 < n_runs && self.longest(at + rest, run + 1, distance).0 > len;
            if is_worth_it && (len >= LONGEST / 2 || !is_next_longer()) {
                distance = back;
                sink.consume(pointer(len, back));
                at += len;
                continue;
            }
            let mut left = rest;
            if is_first {
                sink.consume(Code::Literal(self.bytes[at]));
                left -= 1;
            }
            while left >= SHORTEST {
                // Not so much that one or two bytes are left, which no match can have.
                let len = if left > LONGEST { LONGEST.min(left - SHORTEST) } else { left };
                sink.consume(pointer(len, 1));
                left -= len;
            }
            (0..left).for_each(|_| sink.consume(Code::Literal(self.bytes[at])));
            at += rest;
        }
    }

    fn start(&self, run: usize) -> usize {
        self.starts[run] as usize
    }

    /// What stands for the lengths of a run and of the next, and for its value.
    fn key(&self, run: usize) -> usize {
        let &[first, second, third] = self.starts[run..].first_chunk().expect("two starts behind each run");
        let value = u32::from(self.bytes[first as usize]);
        let mixed = (second - first).wrapping_mul(0x9E37_79B1)
            ^ (third - second).wrapping_mul(0x85EB_CA6B)
            ^ value.wrapping_mul(0xC2B2_AE35);
        (mixed.wrapping_mul(0x27D4_EB2F) >> (32 - KEY_BITS)) as usize
    }

    /// Lets a run be found that the parse has come to.
    fn enter(&mut self, run: usize) {
        if run + 3 < self.starts.len() {
            let key = self.key(run);
            #[expect(clippy::cast_possible_truncation, reason = "fewer runs than bytes")]
            let number = run as u32;
            self.before[run] = std::mem::replace(&mut self.last[key], number);
        }
    }

    /// The longest match found at `at` in a run, and how far back it begins: one as far back as the last, or one after which the
    /// next run has the length of an earlier one.
    fn longest(&self, at: usize, run: usize, distance: usize) -> (usize, usize) {
        let most = (self.bytes.len() - at).min(LONGEST);
        let rest = self.start(run + 1) - at;
        let mut longest = (0, 0);
        if rest >= most {
            return longest;
        }
        let mut from = if distance > 0 { at.checked_sub(distance) } else { None };
        let mut earlier = self.last[self.key(run + 1)];
        for _ in 0..=TRIES {
            if let Some(from) = from.filter(|from| at - from <= usize::from(WINDOW)) {
                let len = common(self.bytes, from, at, most);
                if len > longest.0 {
                    longest = (len, at - from);
                }
            }
            let Some(start) = self.starts.get(earlier as usize) else { break };
            from = (*start as usize).checked_sub(rest);
            earlier = self.before[earlier as usize];
        }
        longest
    }
}

fn pointer(length: usize, backward_distance: usize) -> Code {
    #[expect(clippy::cast_possible_truncation, reason = "at most 258, and at most 2^15")]
    let (length, backward_distance) = (length as u16, backward_distance as u16);
    Code::Pointer { length, backward_distance }
}

/// Where runs of equal bytes begin; behind the last one its end, three times.
#[expect(clippy::cast_possible_truncation, reason = "below 4 GiB")]
fn run_starts(bytes: &[u8]) -> Vec<u32> {
    assert!(u32::try_from(bytes.len()).is_ok(), "below 4 GiB");
    let mut starts = vec![0];
    let mut at = 1;
    while at < bytes.len() {
        let mut changes = differing(bytes, at - 1, at);
        while changes != 0 {
            let byte = changes.trailing_zeros() / 8;
            starts.push(at as u32 + byte);
            changes &= !(0xFF << (8 * byte));
        }
        at += 8;
    }
    starts.extend([bytes.len() as u32; 3]);
    starts
}

/// Which of the eight bytes at two places differ, the first one lowest; bytes beyond the end do not.
#[inline(always)]
fn differing(bytes: &[u8], first: usize, second: usize) -> u64 {
    match (bytes[first..].first_chunk(), bytes[second..].first_chunk()) {
        (Some(first), Some(second)) => u64::from_le_bytes(*first) ^ u64::from_le_bytes(*second),
        _ => {
            let pairs = bytes[first..].iter().zip(&bytes[second..]).take(8).enumerate();
            pairs.fold(0, |word, (k, (first, second))| word | u64::from(first ^ second) << (8 * k))
        }
    }
}

/// How many bytes are the same from two places on, of which the second is farther on: at most `most`.
#[inline(always)]
fn common(bytes: &[u8], first: usize, second: usize, most: usize) -> usize {
    let mut len = 0;
    while len < most {
        let differing = differing(bytes, first + len, second + len);
        if differing != 0 {
            return most.min(len + (differing.trailing_zeros() / 8) as usize);
        }
        len += 8;
    }
    most
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    fn inflated(stream: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(stream).read_to_end(&mut bytes).expect("a zlib stream");
        bytes
    }

    /// Bytes in runs: each with its value and length.
    fn bytes_of(runs: &[(u8, usize)]) -> Vec<u8> {
        runs.iter().flat_map(|(value, len)| std::iter::repeat_n(*value, *len)).collect()
    }

    #[test]
    fn whatever_is_deflated_comes_back() {
        let mut random = 1_u64;
        let mut below = |n: usize| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            usize::try_from(random >> 33).unwrap() % n
        };
        let mut all: Vec<Vec<u8>> = vec![Vec::new(), vec![7], vec![7, 7], vec![7, 8]];
        // Runs around the longest match, alone and behind others.
        for len in (1..12).chain(255..265).chain(510..525).chain([65_535, 65_536]) {
            all.push(bytes_of(&[(3, len)]));
            all.push(bytes_of(&[(1, 5), (0, len), (1, 5), (0, len), (1, 1)]));
        }
        // Random runs; some come again, some from farther back than a match may begin.
        for n_runs in [3, 10, 100, 3000] {
            for longest in [1, 2, 4, 40, 400] {
                for n_values in [1, 2, 3, 256] {
                    let mut runs = Vec::new();
                    for _ in 0..n_runs {
                        match below(4) {
                            0 if !runs.is_empty() => {
                                let first = below(runs.len());
                                runs.extend_from_within(first..runs.len().min(first + 9));
                            }
                            _ => runs.push((u8::try_from(below(n_values)).unwrap(), 1 + below(longest))),
                        }
                    }
                    all.push(bytes_of(&runs));
                }
            }
        }
        for bytes in &all {
            assert!(inflated(&deflate_runs(bytes)) == *bytes, "{} bytes", bytes.len());
        }
    }

    #[test]
    fn a_mask_takes_no_more_than_by_a_search_for_matches() {
        // Wedges of shadow behind boxes, as they are seen from the north-west corner.
        let mask: Vec<u8> = (0..256 * 256)
            .map(|k| {
                let (row, col) = (k / 256 + 1, k % 256 + 1);
                let is_dark = (1..40).any(|k| (row * 40) / col == k * k % 37 && row + col > 9 * k);
                if row % 60 < 20 && col % 60 < 20 { 2 } else { u8::from(!is_dark) }
            })
            .collect();
        let mut searched = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        searched.write_all(&mask).unwrap();
        let searched = searched.finish().unwrap().len();
        let found = deflate_runs(&mask);
        assert!(inflated(&found) == mask);
        assert!(found.len() * 10 < searched * 11, "{} bytes, by a search {searched}", found.len());
    }
}

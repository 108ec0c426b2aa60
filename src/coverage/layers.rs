//! Layers over several UAVs: how many see a cell, which ones, and whether any does.

use super::class;

/// Number of UAVs that see each cell. Cells that are a receiver of none are 0.
pub fn count_layer(masks: &[&[u8]]) -> Vec<u32> {
    let n_cells = masks.first().map_or(0, |m| m.len());
    (0..n_cells).map(|i| masks.iter().map(|m| u32::from(m[i] == class::LOS)).sum()).collect()
}

/// Which UAVs see each cell: one word per 32 UAVs, bit k of word w for UAV 32·w + k.
pub fn which_layer(masks: &[&[u8]]) -> Vec<Vec<u32>> {
    let n_cells = masks.first().map_or(0, |m| m.len());
    let word = |group: &[&[u8]]| {
        (0..n_cells)
            .map(|i| group.iter().enumerate().fold(0, |bits, (k, m)| bits | (u32::from(m[i] == class::LOS) << k)))
            .collect()
    };
    masks.chunks(32).map(word).collect()
}

/// The mask of all UAVs together: LoS if any sees the cell, NLoS if it is a receiver of one, not a receiver if it is in
/// range of one, out of range if it has a height, else nodata.
pub fn union_mask(masks: &[&[u8]]) -> Vec<u8> {
    let rank = |c: u8| match c {
        class::LOS => 0,
        class::NLOS => 1,
        class::NOT_A_RECEIVER => 2,
        class::OUT_OF_RANGE => 3,
        _ => 4,
    };
    let n_cells = masks.first().map_or(0, |m| m.len());
    (0..n_cells).map(|i| masks.iter().map(|m| m[i]).min_by_key(|c| rank(*c)).unwrap_or(class::NODATA)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_bits_and_union_agree() {
        let masks: [&[u8]; 3] = [&[1, 0, 2, 3, 255], &[1, 1, 2, 0, 255], &[0, 0, 2, 3, 255]];
        assert_eq!(count_layer(&masks), [2, 1, 0, 0, 0]);
        assert_eq!(which_layer(&masks), [[0b11, 0b10, 0, 0, 0]]);
        assert_eq!(union_mask(&masks), [1, 1, 2, 0, 255]);
    }
}

//! Maps of classes: the UAVs that see a cell, and the height from which it is seen.

use crate::coverage::class;
use crate::quantity::tidy;
use crate::render::{
    ALONE_COLORS, LEAST_HEIGHT_COLORS, MapClass, ONLY_COLORS, SURE_COLORS, capitalized, grouped, percent,
};

/// Largest number of UAVs that have a color each.
pub(super) const MOST_COLORS: usize = ONLY_COLORS.len() - 2;

/// Class of each cell, with names and colors.
#[derive(Debug)]
pub(super) struct ClassMap {
    /// Class, where the mask is a receiver.
    index: Vec<u8>,
    names: Vec<String>,
    /// Share and number of cells of each class, in words.
    details: Vec<String>,
    colors: Vec<[u8; 3]>,
}

impl ClassMap {
    fn new(index: Vec<u8>, mask: &[u8], classes: Vec<(String, [u8; 3])>) -> Self {
        let mut numbers = vec![0_u64; classes.len()];
        let receivers = index.iter().zip(mask).filter(|(_, class)| is_receiver(**class));
        receivers.for_each(|(k, _)| numbers[usize::from(*k)] += 1);
        let all: u64 = numbers.iter().sum();
        let details = numbers.iter().map(|n| format!("{} · {}", percent(*n, all), grouped(*n))).collect();
        let (names, colors) = classes.into_iter().unzip();
        ClassMap { index, names, details, colors }
    }

    /// Returns the class of each cell.
    pub(super) fn index(&self) -> &[u8] {
        &self.index
    }

    /// Returns the classes for the legend.
    pub(super) fn palette(&self) -> Vec<MapClass<'_>> {
        let both = self.names.iter().zip(&self.details);
        both.zip(&self.colors).map(|((name, detail), color)| MapClass { name, detail, color: *color }).collect()
    }
}

fn is_receiver(of_mask: u8) -> bool {
    matches!(of_mask, class::NLOS | class::LOS)
}

/// Classifies cells by the UAVs that see them: none, only one of a few, several.
pub(super) fn who_sees(who: &str, sites: &[(&str, &[u8])], count: &[u32], union: &[u8]) -> ClassMap {
    let several = sites.len() + 1;
    let index = |cell: usize| match count[cell] {
        0 => 0,
        1 => 1 + sites.iter().position(|(_, mask)| mask[cell] == class::LOS).unwrap_or(0),
        _ => several,
    };
    let index = (0..union.len()).map(|cell| u8::try_from(index(cell)).unwrap_or(u8::MAX)).collect();
    let mut classes = vec![("Seen by none".to_string(), ONLY_COLORS[0])];
    classes.extend(sites.iter().enumerate().map(|(k, (id, _))| (format!("Only by {who} {id}"), ONLY_COLORS[1 + k])));
    let last = if sites.len() == 2 { "both" } else { "several" };
    classes.push((format!("By {last} {who}s"), ONLY_COLORS[ONLY_COLORS.len() - 1]));
    ClassMap::new(index, union, classes)
}

/// Classifies cells by the nearest UAV that sees them. `number` holds its number from 1, or 0 for
/// none.
pub(super) fn nearest(who: &str, ids: &[&str], number: &[u32], union: &[u8]) -> ClassMap {
    let index = number.iter().map(|number| u8::try_from(*number).unwrap_or(u8::MAX)).collect();
    let names =
        std::iter::once("Seen by none".to_string()).chain(ids.iter().map(|id| capitalized(&format!("{who} {id}"))));
    ClassMap::new(index, union, names.zip(ONLY_COLORS).collect())
}

/// Classifies cells for one UAV of many: seen by none, only by others, by it and others, only by
/// it.
pub(super) fn seen_alone(who: &str, mask: &[u8], count: &[u32], union: &[u8]) -> ClassMap {
    let index = |cell: usize| match (mask[cell] == class::LOS, count[cell]) {
        (_, 0) => 0,
        (false, _) => 1,
        (true, 2..) => 2,
        (true, 1) => 3,
    };
    let [both, only] = [format!("By this {who} and others"), format!("Only by this {who}")];
    let names = ["Seen by none".to_string(), "Only by others".to_string(), both, only];
    let classes = names.into_iter().zip(ALONE_COLORS).collect();
    ClassMap::new((0..union.len()).map(index).collect(), union, classes)
}

/// Heights above ground that pilots and rules use \[m\].
const STEPS_M: [f64; 4] = [30.0, 60.0, 120.0, 240.0];

/// Classifies cells by the least height above `base_m` from which they are seen. `base_m` is the
/// ground below the UAV's place, or the datum.
pub(super) fn least_heights(least_m: &[f32], mask: &[u8], base_m: f64, above: &str) -> ClassMap {
    let index = |least: &f32| match f64::from(*least) - base_m {
        height if height < f64::INFINITY => STEPS_M.iter().position(|step| height <= *step).unwrap_or(STEPS_M.len()),
        _ => STEPS_M.len() + 1,
    };
    let index = least_m.iter().map(|least| u8::try_from(index(least)).unwrap_or(u8::MAX)).collect();
    let mut names = vec![format!("Up to {} m above {above}", tidy(STEPS_M[0]))];
    names.extend(STEPS_M.windows(2).map(|ends| format!("{} to {} m", tidy(ends[0]), tidy(ends[1]))));
    names.push(format!("Above {} m", tidy(STEPS_M[STEPS_M.len() - 1])));
    names.push("At no height".to_string());
    ClassMap::new(index, mask, names.into_iter().zip(LEAST_HEIGHT_COLORS).collect())
}

/// Classifies cells by line of sight under uncertain heights of buildings: surely hidden, surely in
/// sight, or dependent on them.
pub(super) fn what_is_sure(sure: &[f32], mask: &[u8]) -> ClassMap {
    let index = |value: &f32| match *value {
        value if value > 1.5 => 2,
        value if value > 0.5 => 1,
        _ => 0,
    };
    let names = ["Surely hidden", "Surely in line of sight", "Hangs on heights of buildings"].map(str::to_string);
    ClassMap::new(sure.iter().map(index).collect(), mask, names.into_iter().zip(SURE_COLORS).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MASKS: [[u8; 5]; 3] = [[0, 1, 1, 0, 2], [0, 0, 1, 3, 2], [0, 0, 0, 1, 2]];
    const COUNT: [u32; 5] = [0, 1, 2, 1, 0];
    const UNION: [u8; 5] = [0, 1, 1, 1, 2];

    #[test]
    fn a_cell_is_that_of_its_only_uav_of_several_or_of_none() {
        let sites = [("a", &MASKS[0][..]), ("b", &MASKS[1]), ("c", &MASKS[2])];
        let map = who_sees("UAV", &sites, &COUNT, &UNION);
        assert_eq!(map.index()[..4], [0, 1, 4, 3]);
        let names: Vec<&str> = map.palette().iter().map(|class| class.name).collect();
        assert_eq!(names, ["Seen by none", "Only by UAV a", "Only by UAV b", "Only by UAV c", "By several UAVs"]);
        // Cells of buildings count in no share.
        assert_eq!(map.palette()[1].detail, "25.0\u{202F}% · 1");
        assert_eq!(who_sees("UAV", &sites[..2], &COUNT, &UNION).palette()[3].name, "By both UAVs");
    }

    #[test]
    fn to_one_uav_of_many_a_cell_is_seen_by_it_alone_with_others_by_others_or_by_none() {
        assert_eq!(seen_alone("UAV", &MASKS[0], &COUNT, &UNION).index()[..4], [0, 3, 2, 1]);
        assert_eq!(seen_alone("UAV", &MASKS[2], &COUNT, &UNION).index()[..4], [0, 1, 1, 3]);
    }

    #[test]
    fn least_heights_are_above_the_ground_and_their_ends_belong_to_the_lower_class() {
        // Nothing limits the last receiver: it is seen from any height.
        let least = [500.0, 530.0, 530.5, 560.0, 620.0, 740.0, 740.5, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        let mask = [1, 1, 1, 1, 0, 0, 0, 0, 1, 2];
        let map = least_heights(&least, &mask, 500.0, "ground");
        assert_eq!(map.index()[..9], [0, 0, 1, 1, 2, 3, 4, 5, 0]);
        let palette = map.palette();
        assert_eq!((palette[0].name, palette[4].name), ("Up to 30 m above ground", "Above 240 m"));
        assert_eq!(palette[1].detail, "22.2\u{202F}% · 2");
    }
}

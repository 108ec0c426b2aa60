//! Families of scenes: the weaknesses that each exposes, and the reasons.

use super::draw::Draw;
use super::scene::{Known, StressScene};
use super::symmetry::Symmetry;
use super::{cells_drawn, cells_known, prisms_drawn, prisms_known, roofs_drawn, truth};
use crate::error::Result;
use crate::quantity::LatticePoint;

/// Family of scenes: any number of them, each a function of the seed and its number.
#[derive(Debug, Clone, Copy)]
pub struct Family {
    /// Name in words and tables; `cell-…` are boards of columns, `prism-…` footprints.
    pub name: &'static str,
    /// Content of its scenes, in plain words.
    pub happens: &'static str,
    /// Methods that it breaks, and the reason.
    pub breaks: &'static str,
    /// Class of methods at risk.
    pub at_risk: AtRisk,
    make: fn(&mut Draw) -> StressScene,
    is_mirrored: bool,
}

/// Class of methods that a family is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AtRisk {
    /// At least one approximate method fails on it.
    Approximate,
    /// Only exact methods can decide it: the approximate ones know only columns.
    ExactOnly,
}

const fn cells(
    name: &'static str,
    happens: &'static str,
    breaks: &'static str,
    make: fn(&mut Draw) -> StressScene,
) -> Family {
    Family { name, happens, breaks, at_risk: AtRisk::Approximate, make, is_mirrored: false }
}

const fn prisms(
    name: &'static str,
    happens: &'static str,
    breaks: &'static str,
    make: fn(&mut Draw) -> StressScene,
) -> Family {
    Family { name, happens, breaks, at_risk: AtRisk::ExactOnly, make, is_mirrored: false }
}

/// Returns the family of the eight symmetries of each scene of `family`.
const fn mirrored(family: Family) -> Family {
    Family { is_mirrored: true, ..family }
}

/// All families. The position in this list is part of the key of their random numbers.
pub const FAMILIES: [Family; 27] = [
    cells(
        "cell-grazing",
        "rays just touch roofs, or miss by 1 mm",
        "slopes rounded to floats, and samples beside the far end of a roof: rays touch roofs exactly or miss by a step",
        cells_known::grazing,
    ),
    cells(
        "cell-borders",
        "the UAV is over a border or corner of cells",
        "rules for ties on grid lines: the UAV is on a border or a corner, rays cross it at the flattest angles between \
         unequal columns (none runs along it, because receivers are in the middle of cells)",
        cells_drawn::borders,
    ),
    cells(
        "cell-diagonals",
        "rays pass where towers touch at a corner",
        "walks that step over one index at a time: exact diagonals pass between towers that touch corner to corner",
        cells_known::diagonals,
    ),
    cells(
        "cell-slits",
        "the only gap is a point where towers touch",
        "everything with a width: what is behind is seen through single points where towers touch",
        cells_known::slits,
    ),
    cells(
        "cell-needles",
        "towers of a single cell",
        "sampling: a tower of one cell is cut by rays along less than a step",
        cells_drawn::needles,
    ),
    cells(
        "cell-slots",
        "openings of a single cell",
        "interpolation and shared rays: an opening of one cell is narrower than what is averaged",
        cells_drawn::slots,
    ),
    cells(
        "cell-cliffs",
        "the UAV is just as high as a plateau",
        "own-cell rules: the UAV is exactly at the height of a plateau, over its edge or a step beside",
        cells_known::cliffs,
    ),
    cells(
        "cell-heights",
        "UAVs 2 m to 20 km up",
        "steps in distance and slopes in floats: UAVs 2 m to 20 km up, rays almost level or almost upright",
        cells_drawn::heights,
    ),
    cells(
        "cell-utm",
        "eastings in the millions, odd oblong cells",
        "floats of seven digits and formulas for square cells: eastings in the millions, odd and oblong cells",
        cells_drawn::utm,
    ),
    cells(
        "cell-magnitudes",
        "heights of 1 mm beside 16 km, and holes",
        "slopes in floats: heights from 1/1024 m to 16 km beside each other, of either sign, with holes",
        cells_drawn::magnitudes,
    ),
    mirrored(cells(
        "cell-mirrors",
        "a town and its mirror images",
        "a favored direction: the eight images of a town must have the eight images of the answer",
        cells_drawn::mirrored,
    )),
    prisms(
        "prism-grazing",
        "rays just touch roofs and corners",
        "tests with an epsilon: roofs and corners touch rays exactly or reach into them by a step",
        prisms_known::grazing,
    ),
    prisms(
        "prism-walls",
        "rays run along walls",
        "tests of one footprint at a time: rays run along walls that are free, shared, or free first on one side",
        prisms_known::walls,
    ),
    prisms(
        "prism-party-walls",
        "houses share walls",
        "footprints shrunk or joined: houses of equal and unequal heights share walls in the middle of cells",
        prisms_drawn::shared_walls,
    ),
    prisms(
        "prism-slits",
        "the only gap is a point where towers touch",
        "polygons with a tolerance: what is behind is seen through single points where towers touch",
        prisms_known::slits,
    ),
    prisms(
        "prism-slivers",
        "slivers and spikes 1 mm wide",
        "triangulations: slivers and spikes a step wide, corners a step apart, holes and rings that touch themselves",
        prisms_drawn::slivers,
    ),
    prisms(
        "prism-needles",
        "towers 1 mm to a hand wide",
        "rasterized footprints: towers from a step to a hand wide, some exactly in a row of receivers",
        prisms_drawn::needles,
    ),
    prisms(
        "prism-roof-height",
        "the UAV is just as high as the roof below",
        "shadows projected from roofs: the UAV is exactly at the height of the roof below it",
        prisms_known::roof_height,
    ),
    prisms(
        "prism-magnitudes",
        "roofs of 1 mm beside 16 km",
        "projections in floats: roofs from 1/1024 m to 16 km beside each other",
        prisms_drawn::magnitudes,
    ),
    prisms(
        "prism-utm",
        "eastings in the millions, odd oblong cells",
        "floats of seven digits: eastings in the millions under odd, oblong cells",
        prisms_drawn::utm,
    ),
    mirrored(prisms(
        "prism-mirrors",
        "a town and its mirror images",
        "a favored direction: the eight images of a town must have the eight images of the answer",
        prisms_drawn::mirrored,
    )),
    cells(
        "cell-curved",
        "the earth bends by meters",
        "heights that a method lowers by another rule: columns and receivers are lower by what the earth falls away by at their middles",
        cells_drawn::curved,
    ),
    prisms(
        "prism-curved",
        "roofs bulge, rays sag",
        "shadows with straight ends: rays sag over a curved earth, touch roofs in their middle, and the ground beyond the horizon",
        prisms_drawn::curved,
    ),
    cells(
        "cell-sectors",
        "receivers on the edge of a sector",
        "angles and distances in floats: receivers exactly on the edges of a sector, at its least radius and at its elevation, among towers",
        cells_drawn::sectors,
    ),
    prisms(
        "prism-sectors",
        "receivers on the edge of a sector",
        "angles and distances in floats: receivers exactly on the edges of a sector, at its least radius and at its elevation, among houses",
        prisms_drawn::sectors,
    ),
    prisms(
        "prism-gables",
        "rays along ridges and slopes",
        "roofs cut flat, and shadows with one height: ridges and slopes touch rays or lie in them, the UAV is on a ridge or in the plane of a slope",
        roofs_drawn::gables,
    ),
    prisms(
        "prism-redrawn",
        "heights change after the city is built",
        "what is known of a city before its heights are redrawn: houses that share walls are moved by a step or by meters, each by itself",
        roofs_drawn::redrawn,
    ),
];

/// Number of symmetries of a square.
const IMAGES: u32 = 8;

impl Family {
    /// Returns the family of a name.
    pub fn named(name: &str) -> Option<&'static Family> {
        FAMILIES.iter().find(|family| family.name == name)
    }

    /// Draws scene `number`. A scene of a mirrored family holds the known answers of its original.
    pub fn scene(&self, seed: u64, number: u32) -> Result<StressScene> {
        let place = FAMILIES.iter().position(|f| f.name == self.name).and_then(|k| u32::try_from(k).ok()).unwrap_or(0);
        let drawn = |number: u32| (self.make)(&mut Draw::new(seed, place, number));
        let scene = if self.is_mirrored {
            let mut original = drawn(number / IMAGES);
            let ready = original.ready()?;
            let answers = truth(&original, &ready)?;
            // A receiver over the wall of two houses is on the one to its north-east, in every
            // image.
            let is_mirrored = |p: &LatticePoint| original.is_board() || p.z == i64::from(original.rx_height);
            let mirrored = ready.receivers.iter().zip(answers).filter(|((_, p), _)| is_mirrored(p));
            let known = mirrored.map(|((cell, _), is_los)| {
                let (row, col) = (cell / original.n_cols, cell % original.n_cols);
                Known { row, col, is_los }
            });
            original.known = known.collect();
            Symmetry::number(number % IMAGES).of(&original)
        } else {
            drawn(number)
        };
        Ok(StressScene { name: format!("{} {number}", self.name), ..scene })
    }
}

//! What was mended or left out while reading footprints: the kinds of faults, counted.

/// What was mended or left out while reading footprints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FootprintFaults {
    /// Features that are not areas (points, lines, no geometry): left out.
    pub not_areas: usize,
    /// Polygons whose rings crossed or touched themselves: repaired by the even-odd rule.
    pub repaired: usize,
    /// Rings whose last point was not the first: closed.
    pub unclosed: usize,
    /// Polygons without area: left out.
    pub degenerate: usize,
    /// Polygons with a hole outside of their shell, or reaching out of it: what is outside is left out.
    pub stray_holes: usize,
    /// Footprints without a usable height: treated as the reader was told.
    pub missing_height: usize,
    /// Of these, the footprints whose height is that of their storeys.
    pub from_levels: usize,
    /// Footprints with a negative height: left out.
    pub negative_height: usize,
    /// Heights written with a decimal comma: read as such.
    pub decimal_comma: usize,
    /// Footprints with a height above ground over terrain that is not known: left out.
    pub no_ground: usize,
    /// Footprints farther than 65 536 m from the grid's corner: left out.
    pub too_far: usize,
    /// Areas that are `building=no` or `building=demolished`: left out.
    pub not_buildings: usize,
    /// Footprints that begin above the ground (`min_height`, `building:min_level`): taken as solid from the ground up.
    pub floating: usize,
    /// Parts of buildings (`building:part`): joined with their outlines, the highest counts.
    pub parts: usize,
}

/// A kind of fault. Its order is that of warnings, and of what is listed for one feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Fault {
    /// No area at all: a point, a line, no geometry.
    NotAnArea,
    /// Rings that cross or touch themselves.
    SelfIntersection,
    /// A hole outside of its shell, or reaching out of it.
    StrayHole,
    /// A ring whose last point is not its first.
    UnclosedRing,
    /// A polygon without area.
    TooSmall,
    /// No ground below it, but nodata.
    NoGround,
    /// Too far from the grid to matter.
    TooFar,
    /// An area that says that it is no building.
    NotABuilding,
    /// No usable height.
    MissingHeight,
    /// A height below zero.
    NegativeHeight,
    /// A decimal comma.
    DecimalComma,
    /// A building that begins above the ground.
    Floating,
    /// A part of a building.
    Part,
    /// A missing height that is that of the storeys.
    HeightFromLevels,
}

impl Fault {
    /// All kinds.
    pub const ALL: [Fault; 14] = [
        Fault::NotAnArea,
        Fault::SelfIntersection,
        Fault::StrayHole,
        Fault::UnclosedRing,
        Fault::TooSmall,
        Fault::NoGround,
        Fault::TooFar,
        Fault::NotABuilding,
        Fault::MissingHeight,
        Fault::NegativeHeight,
        Fault::DecimalComma,
        Fault::Floating,
        Fault::Part,
        Fault::HeightFromLevels,
    ];

    /// A word that never changes its meaning.
    pub fn word(self) -> &'static str {
        match self {
            Fault::NotAnArea => "not-an-area",
            Fault::SelfIntersection => "self-intersection",
            Fault::StrayHole => "stray-hole",
            Fault::UnclosedRing => "unclosed-ring",
            Fault::TooSmall => "too-small",
            Fault::NoGround => "no-ground",
            Fault::TooFar => "too-far",
            Fault::NotABuilding => "not-a-building",
            Fault::MissingHeight => "missing-height",
            Fault::NegativeHeight => "negative-height",
            Fault::DecimalComma => "decimal-comma",
            Fault::Floating => "floating",
            Fault::Part => "building-part",
            Fault::HeightFromLevels => "height-from-levels",
        }
    }

    /// The code of the warning that counts it.
    pub fn code(self) -> u16 {
        match self {
            Fault::NotAnArea => 350,
            Fault::SelfIntersection => 351,
            Fault::StrayHole => 368,
            Fault::UnclosedRing => 352,
            Fault::TooSmall => 353,
            Fault::NoGround => 357,
            Fault::TooFar => 358,
            Fault::NotABuilding => 361,
            Fault::MissingHeight => 354,
            Fault::NegativeHeight => 355,
            Fault::DecimalComma => 356,
            Fault::Floating => 362,
            Fault::Part => 363,
            Fault::HeightFromLevels => 364,
        }
    }

    /// What one and many of them are called.
    pub fn names(self) -> [&'static str; 2] {
        match self {
            Fault::NotAnArea => ["feature that is no polygon", "features that are no polygons"],
            Fault::SelfIntersection => {
                ["polygon with crossing or touching rings", "polygons with crossing or touching rings"]
            }
            Fault::StrayHole => {
                ["polygon with a hole outside of its shell", "polygons with holes outside of their shells"]
            }
            Fault::UnclosedRing => ["ring that does not end where it begins", "rings that do not end where they begin"],
            Fault::TooSmall => ["polygon without area", "polygons without area"],
            Fault::NoGround => [
                "footprint with a height above ground where no terrain is known",
                "footprints with heights above ground where no terrain is known",
            ],
            Fault::TooFar => {
                ["footprint farther than 65536 m from the grid", "footprints farther than 65536 m from the grid"]
            }
            Fault::NotABuilding => {
                ["area that is `building=no` or `demolished`", "areas that are `building=no` or `demolished`"]
            }
            Fault::MissingHeight => ["footprint without a usable height", "footprints without a usable height"],
            Fault::NegativeHeight => ["footprint with a negative height", "footprints with a negative height"],
            Fault::DecimalComma => ["height with a decimal comma", "heights with a decimal comma"],
            Fault::Floating => ["footprint that begins above the ground", "footprints that begin above the ground"],
            Fault::Part => ["part of a building", "parts of buildings"],
            Fault::HeightFromLevels => ["height from a number of storeys", "heights from numbers of storeys"],
        }
    }

    /// What is done about it; of a missing height that depends on the policy.
    pub fn done(self) -> &'static str {
        match self {
            Fault::SelfIntersection => "repaired by the even-odd rule",
            Fault::StrayHole => "what is outside is no building",
            Fault::UnclosedRing => "closed",
            Fault::DecimalComma => "the comma is read as a point",
            Fault::Floating => "taken as solid from the ground up",
            Fault::Part => "joined with their outlines, the highest of what overlaps counts",
            Fault::HeightFromLevels => "3 m for each",
            Fault::NotAnArea
            | Fault::TooSmall
            | Fault::NoGround
            | Fault::TooFar
            | Fault::NotABuilding
            | Fault::MissingHeight
            | Fault::NegativeHeight => LEFT_OUT,
        }
    }
}

/// What is done with most of what cannot be used.
pub const LEFT_OUT: &str = "left out";

impl FootprintFaults {
    /// How many there are of a kind.
    pub fn of(&self, fault: Fault) -> usize {
        let mut counts = *self;
        *counts.of_mut(fault)
    }

    /// The count of a kind.
    pub fn of_mut(&mut self, fault: Fault) -> &mut usize {
        match fault {
            Fault::NotAnArea => &mut self.not_areas,
            Fault::SelfIntersection => &mut self.repaired,
            Fault::StrayHole => &mut self.stray_holes,
            Fault::UnclosedRing => &mut self.unclosed,
            Fault::TooSmall => &mut self.degenerate,
            Fault::NoGround => &mut self.no_ground,
            Fault::TooFar => &mut self.too_far,
            Fault::NotABuilding => &mut self.not_buildings,
            Fault::MissingHeight => &mut self.missing_height,
            Fault::NegativeHeight => &mut self.negative_height,
            Fault::DecimalComma => &mut self.decimal_comma,
            Fault::Floating => &mut self.floating,
            Fault::Part => &mut self.parts,
            Fault::HeightFromLevels => &mut self.from_levels,
        }
    }
}

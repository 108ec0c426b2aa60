//! The kinds of faults of footprints, and a count of each.

/// The treatment of most unusable footprints.
pub const LEFT_OUT: &str = "left out";

/// Defines the kinds: `Kind = word, code of the warning, [singular, plural], treatment;`.
macro_rules! faults {
    ($(#[$attribute:meta])* pub enum $Name:ident {
        $($(#[doc = $doc:literal])+ $Kind:ident = $word:literal, $code:literal, $names:expr, $done:expr;)+
    }) => {
        $(#[$attribute])*
        pub enum $Name {
            $($(#[doc = $doc])+ $Kind),+
        }

        impl $Name {
            /// All kinds.
            pub const ALL: [$Name; [$($code),+].len()] = [$($Name::$Kind),+];

            /// Returns a stable word for the kind.
            pub fn word(self) -> &'static str {
                match self { $($Name::$Kind => $word),+ }
            }

            /// Returns the code of the warning that counts it.
            pub fn code(self) -> u16 {
                match self { $($Name::$Kind => $code),+ }
            }

            /// Returns its names in the singular and the plural.
            pub fn names(self) -> [&'static str; 2] {
                match self { $($Name::$Kind => $names),+ }
            }

            /// Returns the treatment. That of a missing height depends on the reader's policy.
            pub fn done(self) -> &'static str {
                match self { $($Name::$Kind => $done),+ }
            }
        }
    };
}

faults! {
/// A kind of fault of a footprint. The order of variants is the order of warnings, and of the
/// faults listed for one feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FootprintFault {
    /// No area at all (a point, a line, no geometry): left out.
    NotAnArea = "not-an-area", 350, ["feature that is no polygon", "features that are no polygons"], LEFT_OUT;
    /// A polygon whose rings cross or touch themselves: repaired by the even-odd rule.
    SelfIntersection = "self-intersection", 351,
        ["polygon with crossing or touching rings", "polygons with crossing or touching rings"],
        "repaired by the even-odd rule";
    /// A polygon with a hole outside of its shell, or reaching out of it: the part outside is left
    /// out.
    StrayHole = "stray-hole", 368,
        ["polygon with a hole outside of its shell", "polygons with holes outside of their shells"],
        "what is outside is no building";
    /// A ring whose last point is not its first: closed.
    UnclosedRing = "unclosed-ring", 352,
        ["ring that does not end where it begins", "rings that do not end where they begin"],
        "closed";
    /// A polygon without area: left out.
    TooSmall = "too-small", 353, ["polygon without area", "polygons without area"], LEFT_OUT;
    /// A height above ground over unknown terrain: left out.
    NoGround = "no-ground", 357,
        ["footprint with a height above ground where no terrain is known",
         "footprints with heights above ground where no terrain is known"],
        LEFT_OUT;
    /// Farther than 65 536 m from the grid's corner: left out.
    TooFar = "too-far", 358,
        ["footprint farther than 65536 m from the grid", "footprints farther than 65536 m from the grid"],
        LEFT_OUT;
    /// A feature with nothing above the ground: no building, a building not yet or no longer there,
    /// or one below the ground. Left out.
    NotABuilding = "not-a-building", 361,
        ["area that is no building above the ground", "areas that are no buildings above the ground"],
        LEFT_OUT;
    /// No usable height: treated by the reader's policy.
    MissingHeight = "missing-height", 354, ["footprint without a usable height", "footprints without a usable height"],
        LEFT_OUT;
    /// A height below zero: left out.
    NegativeHeight = "negative-height", 355, ["footprint with a negative height", "footprints with a negative height"],
        LEFT_OUT;
    /// A height with a decimal comma: the comma is read as a point.
    DecimalComma = "decimal-comma", 356, ["height with a decimal comma", "heights with a decimal comma"],
        "the comma is read as a point";
    /// A building that begins above the ground (`min_height`, `building:min_level`): taken as solid
    /// from the ground up.
    Floating = "floating", 362, ["footprint that begins above the ground", "footprints that begin above the ground"],
        "taken as solid from the ground up";
    /// A building drawn by its parts (`building:part`, `building_id`): these replace its outline.
    Part = "building-part", 363, ["building drawn by its parts", "buildings drawn by their parts"],
        "the parts stand in place of the outline";
    /// A missing height that is computed from the number of storeys.
    HeightFromLevels = "height-from-levels", 364,
        ["height from a number of storeys", "heights from numbers of storeys"],
        "3 m for each";
    /// A building whose roof reaches beyond its ground surfaces: taken as solid below.
    Overhang = "overhang", 369,
        ["building with a roof that reaches beyond its ground surfaces",
         "buildings with roofs that reach beyond their ground surfaces"],
        "taken as solid below";
    /// A roof with surfaces that cross themselves as seen from above, or are longer than 1024 m:
    /// these surfaces are taken flat.
    RoughRoof = "rough-roof", 374,
        ["roof with surfaces that cross themselves or are longer than 1024 m",
         "roofs with surfaces that cross themselves or are longer than 1024 m"],
        "these are taken flat at their highest";
    /// A roof with surfaces that are not plane to within 5 cm: taken as triangles between their
    /// corners.
    UnevenRoof = "uneven-roof", 376,
        ["roof with surfaces that are no plane to within 5 cm",
         "roofs with surfaces that are no plane to within 5 cm"],
        "these are taken as triangles between their corners";
    /// A building with ground surfaces that its roof does not cover: open there.
    BareGround = "bare-ground", 377,
        ["building with ground surfaces that no roof lies over",
         "buildings with ground surfaces that no roof lies over"],
        "open there";
    /// A building without roof surfaces in a file where other buildings have some: taken flat at
    /// its highest point.
    NoRoof = "no-roof", 381, ["building without a surface of a roof", "buildings without a surface of a roof"],
        "taken flat at its highest point";
    /// A top at or below the ground: left out.
    BelowGround = "below-ground", 382,
        ["building with its top at or below its ground", "buildings with their tops at or below their ground"],
        LEFT_OUT;
}
}

/// The number of faults of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FootprintFaults([usize; FootprintFault::ALL.len()]);

impl FootprintFaults {
    /// Returns the number of faults of a kind.
    pub fn of(&self, fault: FootprintFault) -> usize {
        self.0[fault as usize]
    }

    /// Counts one more fault.
    pub fn add(&mut self, fault: FootprintFault) {
        self.0[fault as usize] += 1;
    }
}

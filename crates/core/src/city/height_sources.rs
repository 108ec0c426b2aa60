//! Sources of the heights of footprints.

use crate::quantity::fixed;

/// The source of a footprint's height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HeightSource {
    /// The file: a property for heights, or the surfaces of the building.
    File,
    /// The number of storeys.
    Storeys,
    /// The median of the heights of the file.
    Median,
    /// A number given by the user.
    Number,
    /// No source: the footprint is left out.
    Nowhere,
}

/// The footprints whose heights come from one source: their number and their share of the area of
/// all footprints.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SourceShare {
    /// Number of footprints.
    pub n: usize,
    /// Share of the area of all footprints, 0 to 1.
    pub area_share: f64,
}

/// The sources of the heights of all footprints of a file.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeightSources([SourceShare; 5]);

impl HeightSource {
    /// All sources, in the order in which they are reported.
    pub const ALL: [HeightSource; 5] =
        [HeightSource::File, HeightSource::Storeys, HeightSource::Median, HeightSource::Number, HeightSource::Nowhere];

    fn place(self) -> usize {
        match self {
            HeightSource::File => 0,
            HeightSource::Storeys => 1,
            HeightSource::Median => 2,
            HeightSource::Number => 3,
            HeightSource::Nowhere => 4,
        }
    }

    /// Returns a stable word for the source.
    pub fn word(self) -> &'static str {
        ["file", "storeys", "median", "number", "nowhere"][self.place()]
    }

    /// Describes what was done with the footprint.
    pub fn done(self) -> &'static str {
        ["from the file", "given a height by storeys", "given the median height", "given a height", "left out"]
            [self.place()]
    }
}

impl HeightSources {
    /// Counts footprints, each given by its source and its area.
    pub fn of(footprints: impl Iterator<Item = (HeightSource, f64)>) -> HeightSources {
        let mut sources = HeightSources::default();
        for (source, area) in footprints {
            let of = &mut sources.0[source.place()];
            *of = SourceShare { n: of.n + 1, area_share: of.area_share + area };
        }
        let total: f64 = sources.0.iter().map(|of| of.area_share).sum();
        if total > 0.0 {
            sources.0.iter_mut().for_each(|of| of.area_share /= total);
        }
        sources
    }

    /// Returns the number and share of footprints of a source.
    pub fn from(&self, source: HeightSource) -> SourceShare {
        self.0[source.place()]
    }

    /// Returns the number and share of footprints without a height of their own.
    pub fn missing(&self) -> SourceShare {
        let sum = |sum: SourceShare, of: &SourceShare| SourceShare {
            n: sum.n + of.n,
            area_share: sum.area_share + of.area_share,
        };
        self.0[1..].iter().fold(SourceShare::default(), sum)
    }

    /// Returns the number of all footprints.
    pub fn n(&self) -> usize {
        self.0.iter().map(|of| of.n).sum()
    }

    /// Describes counts and shares of some sources:
    /// `6 given a height by storeys (3.0 % of the area)`.
    pub fn told(&self, sources: &[HeightSource]) -> String {
        let words = |source: &HeightSource| {
            let of = self.from(*source);
            (of.n > 0)
                .then(|| format!("{} {} ({} % of the area)", of.n, source.done(), fixed(100.0 * of.area_share, 1)))
        };
        sources.iter().filter_map(words).collect::<Vec<_>>().join(", ")
    }

    /// Describes what was done with footprints without a height of their own.
    pub fn treated(&self) -> String {
        self.told(&HeightSource::ALL[1..])
    }
}

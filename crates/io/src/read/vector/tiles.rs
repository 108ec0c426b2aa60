//! Several files of features as one city.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::super::scene_files::SceneFiles;
use super::feature::{Feature, FeatureSet};
use crate::error::{Error, OddFile, Pair, ReadFault, Result, Wanted, Warning, two_crs};
use crate::input::Input;
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::{Crs, CrsKind};

/// Steps of a degree that are about a millimeter.
const STEPS_PER_DEGREE: f64 = 1e8;

/// Features of the files that were read so far.
#[derive(Debug, Default)]
pub(super) struct Tiles {
    whole: FeatureSet,
    /// First file that names a system, and that system.
    named: Option<(Input, Crs)>,
    /// Likenesses of the features.
    seen: HashSet<[u64; 2]>,
    n_read: usize,
    n_outside: usize,
    n_repeated: usize,
}

impl Tiles {
    /// Adds the features of a file. One without buildings adds none.
    pub(super) fn add(&mut self, input: &Input, set: Result<FeatureSet>) -> Result<()> {
        let set = match set {
            Err(error) if error.is_of_nothing() => FeatureSet::default(),
            set => set?,
        };
        match (&self.named, &set.crs) {
            (Some((first, one)), Ok(Some(other))) if !one.same_as(other) => {
                return Err(two_crs((first, one), (input, other), Pair::Tiles));
            }
            (None, Ok(Some(crs))) => self.named = Some((input.clone(), crs.clone())),
            _ => {}
        }
        if !matches!(self.whole.crs, Ok(Some(_))) {
            self.whole.crs = set.crs;
        }
        if set.is_outside {
            self.n_outside += 1;
            return Ok(());
        }
        self.n_read += 1;
        self.whole.oddity = self.whole.oddity.take().or(set.oddity);
        self.whole.attribution = self.whole.attribution.take().or(set.attribution);
        self.whole.name_limit = self.whole.name_limit.or(set.name_limit);
        let is_geographic = match &self.named {
            Some((_, crs)) => matches!(crs.kind(), CrsKind::Geographic),
            None => true,
        };
        let steps = if is_geographic { STEPS_PER_DEGREE } else { f64::from(STEPS_PER_UNIT) };
        // A building on the seam of two tiles stands in both, and counts once.
        let mut of_file = Vec::new();
        for feature in set.features {
            match likeness(&feature, steps) {
                like if self.seen.contains(&like) => self.n_repeated += 1,
                like => {
                    of_file.push(like);
                    self.whole.features.push(feature);
                }
            }
        }
        self.seen.extend(of_file);
        Ok(())
    }

    /// Returns the features of all files, with a warning that counts them.
    ///
    /// # Errors
    /// E308 if no file has a building.
    pub(super) fn whole(self, files: &SceneFiles, warnings: &mut Vec<Warning>, scene: &Input) -> Result<FeatureSet> {
        if self.whole.features.is_empty() && self.n_outside == 0 {
            return Err(Error::read(scene, ReadFault::Nothing(Wanted::Building)));
        }
        let Tiles { whole, n_read, n_outside, n_repeated, .. } = self;
        let n_others = files.n_others;
        if n_others + n_outside > 0 {
            warnings.push(Warning::of(scene, OddFile::Tiles { n_read, n_outside, n_repeated, n_others }));
        }
        Ok(whole)
    }
}

/// Returns two hashes of the id and the areas of a feature, its corners in some steps of a unit.
/// Without an id, all properties count.
fn likeness(feature: &Feature, steps: f64) -> [u64; 2] {
    let name = match feature.known_id() {
        Some(id) => id,
        None => format!("{:?}", feature.properties),
    };
    [0_u8, 1].map(|seed| {
        let mut hasher = DefaultHasher::new();
        (seed, &name).hash(&mut hasher);
        for ring in feature.polygons.iter().flatten() {
            ring.len().hash(&mut hasher);
            #[expect(clippy::cast_possible_truncation, reason = "saturates")]
            ring.iter().for_each(|p| p.map(|v| (v * steps).round() as i64).hash(&mut hasher));
        }
        hasher.finish()
    })
}

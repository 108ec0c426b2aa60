//! `skyshed plos`: probability of line of sight.

use std::path::PathBuf;

use super::plos_args::PlosArgs;
use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::args::words::Numbers;
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::picture::Look;
use crate::plos::{FORMATS, Far, PlosPlan, Sweeps, read_curves};
use crate::scene::built_up;

/// What only cities in files can use.
const OF_FILES: [&str; 25] = [
    "roofs",
    "terrain",
    "extent",
    "cell",
    "crs",
    "project",
    "building_threshold",
    "height_field",
    "top_field",
    "missing",
    "nodata_as",
    "band",
    "ground",
    "hash",
    "positions",
    "block",
    "base",
    "data_area",
    "height_unit",
    "base_field",
    "levels_field",
    "parts",
    "layer",
    "theta_band",
    "attribution",
];

impl PlosArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let mut warnings = Vec::new();
        let curves = read_curves(&self.curve, self.skip_bad, &mut warnings)?;
        let files = self
            .scenes
            .iter()
            .filter(|word| built_up(word).is_none())
            .flat_map(|word| scene_files(word, &self.reading));
        let inputs: Vec<PathBuf> = files.chain(curves.iter().map(|(_, path)| path.clone())).collect();
        let outputs = checked_files(&self.out, self.csv.as_ref(), (&FORMATS, &inputs))?;
        let look = Look::checked(&self.picture, &self.out.writing, &outputs)?;
        let is_drawn = outputs.iter().any(|(_, format)| format.is_picture());
        self.refuse_idle(run, is_drawn)?;
        let plan = PlosPlan {
            scenes: self.scenes.clone(),
            options: run.reader(&self.reading),
            sweeps: self.sweeps()?,
            methods: self.method.clone(),
            curves,
            warnings,
            rx_height_m: self.rx_height,
            uav_clear_of_roof: self.uav_clear_of_roof,
            until: self.until,
            tolerance: self.tolerance,
            confidence: self.ci,
            n_cities: self.cities,
            n_users: self.users_per_city,
            n_links: self.links,
            n_positions: self.positions,
            theta_band_deg: self.theta_band,
            block_m: self.block,
            seed: self.reading.options.seed_or_default(),
            plot: self.plot,
            is_drawn,
            hash: self.reading.options.hash,
            command: run.words(),
        };
        plan.check()?;
        run.emit(&plan.run()?, &outputs, (&self.out, &look))
    }

    fn sweeps(&self) -> Result<Sweeps> {
        let list = |numbers: &Option<Numbers>| numbers.as_ref().map(|n| n.0.clone());
        let far = match (&self.distance, &self.radius, &self.theta) {
            (Some(d), _, _) => d.0.iter().copied().map(Far::Distance).collect(),
            (_, Some(r), _) => r.0.iter().copied().map(Far::Radius).collect(),
            (_, _, Some(t)) => t.0.iter().copied().map(Far::Theta).collect(),
            _ => Far::every_five_degrees(),
        };
        let sweeps = Sweeps {
            placements: self.placement.clone(),
            users: self.users.clone(),
            alphas: list(&self.alpha),
            betas: list(&self.beta),
            gammas: list(&self.gamma),
            heights: self.height.0.clone(),
            phis: list(&self.phi).map_or_else(|| vec![None], |phis| phis.into_iter().map(Some).collect()),
            far,
        };
        Ok(sweeps.checked()?)
    }

    /// An ignored input is an error, never silence.
    fn refuse_idle(&self, run: &Run, is_drawn: bool) -> Result<()> {
        let has_file = self.scenes.iter().any(|word| built_up(word).is_none());
        let uses = |names: &[&str]| self.method.iter().any(|m| names.contains(&m.trim().to_lowercase().as_str()));
        if !has_file {
            run.typed.refuse(&OF_FILES, "without a city in a file")?;
        }
        if self.distance.is_some() || self.radius.is_some() {
            run.typed.refuse(&["theta_band"], "without `--theta`")?;
        }
        run.typed.refuse(&["size"], "here: a city is as large as the links over it")?;
        if !uses(&["city", "all"]) {
            run.typed.refuse(&["cities", "users_per_city"], "without `--method city`")?;
        }
        if !uses(&["geometry", "all"]) {
            run.typed.refuse(&["links"], "without `--method geometry`")?;
        }
        if self.until.is_some() && (run.typed.has("cities") || run.typed.has("links")) {
            let text = "`--until` has no meaning together with `--cities` or `--links`, which fix the effort";
            return Err(refusal(116, text));
        }
        if !is_drawn {
            run.typed.refuse(&["plot"], "without a .png, .svg or .pdf output")?;
        }
        Ok(())
    }
}

//! `skyshed info`: what a scene is.

mod needs;
mod scene;
mod tiles;

use super::args::InfoArgs;
use crate::error::Result;

pub(super) fn run(args: &InfoArgs, command: Vec<String>) -> Result<()> {
    scene::run(args, command)
}

//! The `skyshed` program: see [`skyshed::cli`].

#[global_allocator]
static ALLOCATOR: skyshed::cli::Allocator = skyshed::cli::Allocator;

fn main() -> std::process::ExitCode {
    skyshed::cli::run(std::env::args_os())
}

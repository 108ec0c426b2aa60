//! The `skyshed` program: see [`skyshed::cli`].

fn main() -> std::process::ExitCode {
    skyshed::cli::run(std::env::args_os())
}

//! Project chores: `cargo xtask ci` runs what CI runs, `cargo xtask layers` checks which crate may import which,
//! `cargo xtask unity-kernels` writes the kernels as Unity takes them.

mod ci;
mod layers;
mod package;
mod unity_kernels;
mod unity_kernels_hlsl;
mod unity_metas;

use std::path::Path;
use std::process::ExitCode;

const HELP: &str = "\
Usage: cargo xtask <COMMAND>

Commands:
  ci      Format check, clippy, import rules, tests, documentation, licences: what CI runs
  layers  Check that imports between the crates go one way
  package python OUT        Make the Python wheel in the folder OUT
  package unity OUT         Make the Unity package, with this system's library in it, in the folder OUT
  package unity OUT --from DIR
                            The same, with a library and a program that are built
  package unity OUT [--from DIR] --library FILE...
                            With those of other systems, too, that were built there: lumivox_unity.dll,
                            liblumivox_unity.dylib, and lumivox-codecs as it is called there
  unity-kernels             Write the Unity package's kernels, and the table of their names
  unity-kernels --check     Fail where they are not what would be written
  unity-kernels --all DIR   Write every kernel of every view there, for tests
  unity-metas               Give each file of the Unity package its identifier
  unity-metas --check       Fail where one is missing, left over or there twice

Exit codes: 0 all is well, 1 a check failed, 2 wrong usage";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["ci"] => ci::run(),
        ["layers"] => layers::run(),
        ["unity-kernels"] => unity_kernels::write(),
        ["unity-kernels", "--check"] => unity_kernels::check(),
        ["unity-kernels", "--all", folder] => unity_kernels::write_all(Path::new(folder)),
        ["package", "python", out] => package::python(Path::new(out)),
        ["package", "unity", out, ref options @ ..] if !out.starts_with('-') => {
            match package::options(options) {
                Some((from, others)) => package::unity(Path::new(out), from, &others),
                None => {
                    eprintln!("{HELP}");
                    return ExitCode::from(2);
                }
            }
        }
        ["unity-metas"] => unity_metas::write(),
        ["unity-metas", "--check"] => unity_metas::check(),
        ["help" | "--help" | "-h"] => {
            println!("{HELP}");
            Ok(())
        }
        _ => {
            eprintln!("{HELP}");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("\nxtask: {message}");
            ExitCode::FAILURE
        }
    }
}

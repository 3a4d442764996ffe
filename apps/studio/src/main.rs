//! The program of a desktop.

fn main() -> std::process::ExitCode {
    lumivox_studio::native::main()
}

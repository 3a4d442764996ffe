//! The program of a desktop.

// Who starts it by a double click wants no console beside it.
#![cfg_attr(windows, windows_subsystem = "windows")]

fn main() -> std::process::ExitCode {
    lumivox_studio::native::main()
}

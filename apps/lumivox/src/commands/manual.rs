//! `lumivox manual`: man pages and what shells complete, made of the options that there are, for whoever packs this command.

use std::{fs, path::Path};

use clap::CommandFactory;
use clap_complete::Shell;
use clap_mangen::Man;

use crate::{args::Cli, exit::Failure};

/// Writes `man1` and `completions` into a folder.
pub fn run(out: &Path) -> Result<(), Failure> {
    let mut command = Cli::command();
    command.build();
    let pages = out.join("man1");
    write_pages(&command, &pages)?;
    let completions = out.join("completions");
    make(&completions)?;
    for (shell, name) in [
        (Shell::Bash, "lumivox.bash"),
        (Shell::Zsh, "_lumivox"),
        (Shell::Fish, "lumivox.fish"),
        (Shell::PowerShell, "lumivox.ps1"),
    ] {
        let mut text = vec![];
        // It takes the command as it was written, and builds it itself.
        clap_complete::generate(shell, &mut Cli::command(), "lumivox", &mut text);
        write(&completions.join(name), &text)?;
    }
    Ok(())
}

/// A page for the command, and one for each of its commands.
fn write_pages(command: &clap::Command, folder: &Path) -> Result<(), Failure> {
    make(folder)?;
    let name = command.get_display_name().unwrap_or(command.get_name()).replace(' ', "-");
    let mut text = vec![];
    // Without a date, which would differ from day to day.
    let page = Man::new(command.clone()).title(name.to_uppercase()).manual("Lumivox");
    let file = folder.join(format!("{name}.1"));
    page.render(&mut text).map_err(|error| Failure::other(format!("{}: {error}", file.display())))?;
    write(&file, &text)?;
    let mut commands = command.get_subcommands().filter(|command| command.get_name() != "help");
    commands.try_for_each(|command| write_pages(command, folder))
}

fn make(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| Failure::other(format!("{}: {error}", folder.display())))
}

fn write(file: &Path, text: &[u8]) -> Result<(), Failure> {
    fs::write(file, text).map_err(|error| Failure::other(format!("{}: {error}", file.display())))
}

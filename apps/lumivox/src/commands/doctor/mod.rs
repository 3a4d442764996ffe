//! `lumivox doctor`: what this machine has for rendering, and what it lacks.

mod picture;
mod report;
mod system;

use std::{fs, time::Instant};

use lumivox_wgpu::{Gpu, GpuDescription, GpuError};

use self::{
    picture::TestPicture,
    report::{Tried, report},
    system::System,
};
use crate::{
    args::DoctorArgs,
    exit::{Exit, Failure},
    output::{self, Picture, PngOutput},
    progress::Reporter,
    trace,
};

/// Prints what is seen; fails when nothing can render.
pub fn run(args: &DoctorArgs) -> Result<(), Failure> {
    if let Some(folder) = &args.pictures {
        fs::create_dir_all(folder).map_err(|error| {
            Failure::other(format!("cannot make the folder {}: {error}", folder.display()))
        })?;
    }
    let test = TestPicture::new()?;
    let reporter = Reporter::new(args.quiet);
    let system = System::look();
    let mut tried = vec![];
    for (index, gpu) in Gpu::list().into_iter().enumerate() {
        reporter.say(&format!("trying {}", trace::describe(&gpu)));
        let begin = Instant::now();
        let unsuitable = match try_out(index, &gpu, &test) {
            Ok(picture) => {
                if let Some(folder) = &args.pictures {
                    let path = folder.join(file_name(index, &gpu));
                    PngOutput::prepare(&path, [])?.write(&picture)?;
                    reporter.say(&format!("Wrote {}", path.display()));
                }
                None
            }
            Err(reason) => Some(reason),
        };
        tried.push(Tried { gpu: GpuDescription { unsuitable, ..gpu }, took: begin.elapsed() });
    }
    output::print(&report(&system, &tried))?;
    if tried.iter().any(Tried::works) {
        return Ok(());
    }
    Err(Failure::new(Exit::Gpu, format!("no GPU can be used. {}.", system.remedy())))
}

/// Has a device render, or says what is wrong with it.
fn try_out(index: usize, gpu: &GpuDescription, test: &TestPicture) -> Result<Picture, String> {
    if let Some(reason) = &gpu.unsuitable {
        return Err(reason.clone());
    }
    let opened = Gpu::open_at(index).and_then(|mut gpu| {
        // What a driver fails at here is its fault; later it would be called ours.
        gpu.try_out()?;
        Ok(gpu)
    });
    let mut gpu = opened.map_err(|error| match error {
        GpuError::Unsuitable { reason, .. } => reason,
        error => error.to_string(),
    })?;
    test.by(&mut gpu)
}

/// Of the picture by a device: several may have one name.
fn file_name(index: usize, gpu: &GpuDescription) -> String {
    let words: Vec<_> =
        gpu.name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    format!("{}-{}-{}.png", index + 1, words.join("-"), gpu.backend).to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_named_by_place_and_device() {
        let gpu = GpuDescription {
            name: "B (TM) 2".into(),
            driver: "Mesa".into(),
            backend: "Vulkan".into(),
            software: false,
            unsuitable: None,
        };
        assert_eq!(file_name(1, &gpu), "2-b-tm-2-vulkan.png");
    }
}

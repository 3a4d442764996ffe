//! `lumivox doctor`: what this machine has for rendering, and what it lacks.

use std::{
    borrow::Cow,
    fmt::Write,
    path::{Path, PathBuf},
};

use lumivox_wgpu::{Gpu, GpuDescription};

use crate::{
    exit::{Exit, Failure},
    output, trace,
};

/// Prints what is seen; fails when nothing can render.
pub fn run() -> Result<(), Failure> {
    let system = System::look();
    let gpus = Gpu::list_tried();
    output::print(&report(&system, &gpus))?;
    if gpus.iter().any(|gpu| gpu.unsuitable.is_none()) {
        return Ok(());
    }
    Err(Failure::new(Exit::Gpu, format!("no GPU can be used. {}.", system.remedy())))
}

/// What can be seen of GPUs without asking a graphics API.
#[derive(Debug, Default)]
struct System {
    os: &'static str,
    /// Device files of GPUs.
    devices: Vec<PathBuf>,
    /// The Vulkan loader, where there is one.
    loader: Option<PathBuf>,
    /// Manifests of Vulkan drivers.
    drivers: Vec<PathBuf>,
    /// The variable that makes the Vulkan loader look elsewhere for drivers, where one is set.
    variable: Option<&'static str>,
}

impl System {
    fn look() -> Self {
        let mut system = Self { os: std::env::consts::OS, ..Self::default() };
        if system.os == "linux" {
            system.devices = files_in(Path::new("/dev/dri"), |name| name.starts_with("renderD"));
            system.devices.extend(files_in(Path::new("/dev"), |name| name == "dxg" || name == "nvidia0"));
            let libraries = ["/usr/lib", "/usr/lib64", "/lib", "/usr/local/lib"].map(PathBuf::from);
            let multiarch = libraries[0].join(format!("{}-linux-gnu", std::env::consts::ARCH));
            system.loader = std::iter::once(multiarch)
                .chain(libraries)
                .map(|folder| folder.join("libvulkan.so.1"))
                .find(|path| path.exists());
            for folder in ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"] {
                system.drivers.extend(files_in(Path::new(folder), |name| name.ends_with(".json")));
            }
            let set = |name: &&str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
            system.variable = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].into_iter().find(set);
        }
        system
    }

    /// What to do when nothing can render, or when only software can though there is a GPU.
    fn remedy(&self) -> Cow<'static, str> {
        if let (Some(variable), true) = (self.variable, self.loader.is_some()) {
            return format!("{variable} is set, so that only the drivers it names are used: unset it").into();
        }
        let nvidia = self.devices.iter().any(|device| device.ends_with("nvidia0"));
        Cow::Borrowed(match self.os {
            "linux" if self.loader.is_none() => {
                "Install the Vulkan loader and drivers: sudo apt-get install libvulkan1 mesa-vulkan-drivers \
                 (Debian, Ubuntu), vulkan-loader mesa-vulkan-drivers (Fedora), vulkan-icd-loader vulkan-swrast (Arch)"
            }
            "linux" if nvidia => {
                "There is an NVIDIA GPU, but its Vulkan driver does not answer: install the graphics part of NVIDIA's \
                 driver (Debian: nvidia-vulkan-icd); in a container, allow NVIDIA_DRIVER_CAPABILITIES=graphics"
            }
            "linux" => {
                "Install Vulkan drivers; they include one that runs on the CPU: sudo apt-get install \
                 mesa-vulkan-drivers (Debian, Ubuntu, Fedora: the same name), vulkan-swrast (Arch)"
            }
            "windows" => "Install the graphics driver of the GPU's maker: Vulkan or Direct3D 12 is needed",
            "macos" => "Metal is needed: macOS 10.14 or later on a Mac of 2012 or later",
            _ => "Vulkan, Direct3D 12 or Metal is needed",
        })
    }
}

fn files_in(folder: &Path, wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(&wanted))
        .map(|entry| entry.path())
        .collect();
    files.sort();
    files
}

fn report(system: &System, gpus: &[GpuDescription]) -> String {
    let mut text =
        format!("lumivox {} on {} {}\n", env!("CARGO_PKG_VERSION"), system.os, std::env::consts::ARCH);
    if system.os == "linux" {
        let list = |paths: &[PathBuf]| {
            let paths: Vec<_> = paths.iter().map(|path| path.display().to_string()).collect();
            if paths.is_empty() { "none".to_owned() } else { paths.join(", ") }
        };
        let _ = writeln!(text, "GPU devices     {}", list(&system.devices));
        let _ = writeln!(text, "Vulkan loader   {}", list(system.loader.as_slice()));
        let _ = writeln!(text, "Vulkan drivers  {}", list(&system.drivers));
        if let Some(variable) = system.variable {
            let _ = writeln!(text, "                only those that {variable} names are used");
        }
    }
    let (usable, unusable): (Vec<_>, Vec<_>) = gpus.iter().partition(|gpu| gpu.unsuitable.is_none());
    text += "\nCan render, the one taken by default first:\n";
    usable.iter().for_each(|gpu| text += &format!("  {}\n", trace::describe(gpu)));
    if usable.is_empty() {
        text += "  none\n";
    }
    for gpu in unusable {
        let reason = gpu.unsuitable.as_deref().unwrap_or_default();
        let _ = writeln!(text, "Cannot render: {}: {reason}", trace::describe(gpu));
    }
    if !usable.is_empty() && usable.iter().all(|gpu| gpu.software) {
        text += "\nRendering works, on the CPU, and is slow.\n";
        if !system.devices.is_empty() {
            let _ = writeln!(text, "This machine has a GPU that is not used. {}.", system.remedy());
        }
    } else if !usable.is_empty() {
        text += "\nAll is well.\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gpu(software: bool) -> GpuDescription {
        GpuDescription {
            name: "llvmpipe".into(),
            driver: "Mesa".into(),
            backend: "Vulkan".into(),
            software,
            unsuitable: None,
        }
    }

    #[test]
    fn the_report_says_what_is_missing() {
        let linux = System { os: "linux", ..System::default() };
        assert!(linux.remedy().contains("libvulkan1"));
        let text = report(&linux, &[]);
        assert!(text.contains("Vulkan loader   none") && text.contains("  none\n"), "{text}");

        let nvidia = System {
            os: "linux",
            devices: vec!["/dev/nvidia0".into()],
            loader: Some("/usr/lib/libvulkan.so.1".into()),
            ..System::default()
        };
        let text = report(&nvidia, &[gpu(true)]);
        assert!(text.contains("a GPU that is not used") && text.contains("NVIDIA"), "{text}");
        let text = report(&nvidia, &[gpu(false)]);
        assert!(text.contains("All is well"), "{text}");

        let elsewhere = System { variable: Some("VK_DRIVER_FILES"), ..nvidia };
        assert!(elsewhere.remedy().contains("VK_DRIVER_FILES is set"));
        assert!(report(&elsewhere, &[]).contains("VK_DRIVER_FILES"));
    }
}

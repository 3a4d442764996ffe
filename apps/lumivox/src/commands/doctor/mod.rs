//! `lumivox doctor`: what this machine has for rendering, and what it lacks.

mod picture;

use std::{
    borrow::Cow,
    fmt::Write,
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use lumivox_wgpu::{Gpu, GpuDescription, GpuError};

use self::picture::TestPicture;
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
    let mut gpu = Gpu::open_at(index).map_err(|error| match error {
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

/// A device, and how it did; why it is no good is in its description.
#[derive(Debug)]
struct Tried {
    gpu: GpuDescription,
    /// From its opening to the picture.
    took: Duration,
}

impl Tried {
    fn works(&self) -> bool {
        self.gpu.unsuitable.is_none()
    }
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
    /// Whether somebody sees this desktop from another machine.
    is_remote: bool,
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
        // Windows names a session at the machine itself 'Console'.
        system.is_remote = system.os == "windows"
            && std::env::var("SESSIONNAME").is_ok_and(|name| name.to_uppercase().starts_with("RDP-"));
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
            "windows" if self.is_remote => {
                "This is a remote desktop, which may hide the GPU: try it at the machine itself, or have its group policy \
                 'Use hardware graphics adapters for all Remote Desktop Services sessions' switched on"
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

fn report(system: &System, tried: &[Tried]) -> String {
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
    let (usable, unusable): (Vec<_>, Vec<_>) = tried.iter().partition(|tried| tried.works());
    text += "\nCan render, the one taken by default first:\n";
    for Tried { gpu, took } in &usable {
        let _ = writeln!(text, "  {}: a test picture in {:.1} s", trace::describe(gpu), took.as_secs_f64());
    }
    if usable.is_empty() {
        text += "  none\n";
    }
    for Tried { gpu, .. } in unusable {
        let reason = gpu.unsuitable.as_deref().unwrap_or_default();
        let _ = writeln!(text, "Cannot render: {}: {reason}", trace::describe(gpu));
        if !gpu.software {
            text += "  A newer driver of the GPU's maker may help.\n";
        }
    }
    let hardware = |tried: &&&Tried| !tried.gpu.software;
    let mut names: Vec<_> = usable.iter().filter(hardware).map(|tried| tried.gpu.name.as_str()).collect();
    names.dedup();
    if let [_, other, ..] = names[..] {
        let _ = writeln!(text, "\nThere are several GPUs: --gpu \"{other}\" renders on that one.");
    }
    if !usable.is_empty() && usable.iter().all(|tried| tried.gpu.software) {
        text += "\nRendering works, on the CPU, and is slow.\n";
        if !system.devices.is_empty() || system.is_remote {
            let _ = writeln!(text, "A GPU of this machine may not be used. {}.", system.remedy());
        }
    } else if !usable.is_empty() {
        text += "\nAll is well.\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gpu(software: bool) -> Tried {
        let gpu = GpuDescription {
            name: "llvmpipe".into(),
            driver: "Mesa".into(),
            backend: "Vulkan".into(),
            software,
            unsuitable: None,
        };
        Tried { gpu, took: Duration::from_millis(1230) }
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
        assert!(text.contains("A GPU of this machine may not be used") && text.contains("NVIDIA"), "{text}");
        let text = report(&nvidia, &[gpu(false)]);
        assert!(text.contains("All is well"), "{text}");

        let elsewhere = System { variable: Some("VK_DRIVER_FILES"), ..nvidia };
        assert!(elsewhere.remedy().contains("VK_DRIVER_FILES is set"));
        assert!(report(&elsewhere, &[]).contains("VK_DRIVER_FILES"));
    }

    #[test]
    fn the_report_says_what_each_device_did() {
        let system = System { os: "windows", ..System::default() };
        let named = |name: &str, unsuitable: Option<&str>| {
            let of = gpu(false);
            let unsuitable = unsuitable.map(str::to_owned);
            Tried { gpu: GpuDescription { name: name.into(), unsuitable, ..of.gpu }, ..of }
        };
        let text = report(&system, &[named("A 1", None), named("A 1", None), named("B", Some("it is old"))]);
        assert!(text.contains("  A 1 (Vulkan, Mesa): a test picture in 1.2 s\n"), "{text}");
        assert!(text.contains("Cannot render: B (Vulkan, Mesa): it is old\n  A newer driver"), "{text}");
        // One by two ways is not two.
        assert!(!text.contains("several"), "{text}");
        let text = report(&system, &[named("A", None), named("B 2", None)]);
        assert!(text.contains("several GPUs: --gpu \"B 2\""), "{text}");
        assert_eq!(file_name(1, &named("B (TM) 2", None).gpu), "2-b-tm-2-vulkan.png");

        let remote = System { is_remote: true, ..system };
        let text = report(&remote, &[gpu(true)]);
        assert!(text.contains("on the CPU") && text.contains("remote desktop"), "{text}");
        assert!(remote.remedy().contains("remote desktop"));
    }
}

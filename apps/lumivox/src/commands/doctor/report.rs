//! What the doctor says of a machine, in words for those who never heard of Vulkan.

use std::{fmt::Write, path::PathBuf, time::Duration};

use lumivox_wgpu::GpuDescription;

use super::system::System;
use crate::trace;

/// A device, and how it did; why it is no good is in its description.
#[derive(Debug)]
pub struct Tried {
    pub gpu: GpuDescription,
    /// From its opening to the picture.
    pub took: Duration,
}

impl Tried {
    pub fn works(&self) -> bool {
        self.gpu.unsuitable.is_none()
    }
}

pub fn report(system: &System, tried: &[Tried]) -> String {
    let (usable, unusable): (Vec<&Tried>, Vec<&Tried>) = tried.iter().partition(|tried| tried.works());
    let mut text = what_is_there(system);
    text += "\nCan render, the one taken by default first:\n";
    for Tried { gpu, took } in &usable {
        let _ = writeln!(text, "  {}: a test picture in {:.1} s", trace::describe(gpu), took.as_secs_f64());
    }
    if usable.is_empty() {
        text += "  none\n";
    }
    let mut is_worried = false;
    for Tried { gpu, .. } in unusable {
        let reason = in_one_line(gpu.unsuitable.as_deref().unwrap_or_default());
        let _ = writeln!(text, "Cannot render: {}: {reason}", trace::describe(gpu));
        let (advice, harms) = advice(system, gpu, &reason, &usable);
        is_worried |= harms;
        if !advice.is_empty() {
            let _ = writeln!(text, "  {advice}");
        }
    }
    let mut names: Vec<&str> = vec![];
    for tried in usable.iter().filter(|tried| !tried.gpu.software) {
        // One by two ways is not two.
        if !names.contains(&tried.gpu.name.as_str()) {
            names.push(&tried.gpu.name);
        }
    }
    if let [_, other, ..] = names[..] {
        let _ = writeln!(text, "\nThere are several GPUs: --gpu \"{other}\" renders on that one.");
    }
    if usable.is_empty() {
    } else if usable.iter().all(|tried| tried.gpu.software) {
        text += "\nRendering works, on the CPU, and is slow.\n";
        // What is said of a GPU above is better than a guess whether there is one.
        if let Some(why) = system.why_no_gpu().filter(|_| !is_worried || system.is_remote) {
            let _ = writeln!(text, "{why}");
        }
    } else if is_worried {
        text += "\nRendering works, but not by every GPU.\n";
    } else {
        text += "\nAll is well.\n";
    }
    if !usable.is_empty() && usable.iter().all(|tried| tried.gpu.backend == "Dx12") {
        text += "Only Direct3D is there, which takes minutes before a first picture: the driver of the GPU's maker brings \
                 Vulkan, which takes seconds.\n";
    }
    if system.is_marked {
        text += "\nWindows has marked this program as one from the web. Engines may say of libraries so marked that they are not there: in \
                 PowerShell, in their folder, 'Get-ChildItem -Recurse | Unblock-File' takes the mark off.\n";
    }
    text
}

/// What was seen without trying.
fn what_is_there(system: &System) -> String {
    let wine = if system.is_wine { ", in Wine" } else { "" };
    let mut text =
        format!("lumivox {} on {} {}{wine}\n", env!("CARGO_PKG_VERSION"), system.os, std::env::consts::ARCH);
    let list = |paths: &[PathBuf]| {
        let paths: Vec<_> = paths.iter().map(|path| path.display().to_string()).collect();
        if paths.is_empty() { "none".to_owned() } else { paths.join(", ") }
    };
    if system.os == "linux" {
        let _ = writeln!(text, "GPU devices     {}", list(&system.devices));
    }
    if matches!(system.os, "linux" | "windows") {
        let _ = writeln!(text, "Vulkan loader   {}", list(system.loader.as_slice()));
    }
    if system.os == "linux" {
        let _ = writeln!(text, "Vulkan drivers  {}", list(&system.drivers));
    }
    if system.os == "windows" {
        let _ = writeln!(text, "Direct3D 12     {}", list(system.direct3d.as_slice()));
    }
    if let Some(variable) = system.variable {
        let _ = writeln!(text, "                only the drivers that {variable} names are used");
    }
    text
}

/// Drivers' reasons have lines, and causes of causes.
fn in_one_line(reason: &str) -> String {
    let lines = reason.lines().map(|line| line.trim().trim_end_matches(':'));
    lines.filter(|line| !line.is_empty() && *line != "Caused by").collect::<Vec<_>>().join(": ")
}

/// What helps where a device cannot render, and whether anything is lost by that.
fn advice(system: &System, gpu: &GpuDescription, reason: &str, usable: &[&Tried]) -> (&'static str, bool) {
    let is_direct3d = gpu.backend == "Dx12";
    if usable.iter().any(|other| other.gpu.name == gpu.name) {
        ("It renders in another way, see above: nothing is lost.", false)
    } else if is_direct3d && system.is_wine {
        (
            "Wine's Direct3D lacks what rendering needs, and may call a GPU what it is not: Vulkan is what counts.",
            false,
        )
    } else if is_direct3d && reason.contains("D3DCompile") {
        (
            "Direct3D's compiler, d3dcompiler_47.dll, is missing or broken: Windows Update brings it. A driver with \
             Vulkan needs none.",
            true,
        )
    } else if gpu.software {
        ("", false)
    } else if reason.contains("less than WebGPU asks") {
        ("A newer driver of the GPU's maker may help; GPUs older than some 2015 cannot.", true)
    } else {
        ("A newer driver of the GPU's maker may help.", true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tried(name: &str, backend: &str, software: bool, unsuitable: Option<&str>) -> Tried {
        let gpu = GpuDescription {
            name: name.into(),
            driver: "Mesa".into(),
            backend: backend.into(),
            software,
            unsuitable: unsuitable.map(str::to_owned),
        };
        Tried { gpu, took: Duration::from_millis(1230) }
    }

    fn works(name: &str) -> Tried {
        tried(name, "Vulkan", false, None)
    }

    fn llvmpipe() -> Tried {
        tried("llvmpipe", "Vulkan", true, None)
    }

    fn windows() -> System {
        System { os: "windows", ..System::default() }
    }

    #[test]
    fn the_report_says_what_is_missing() {
        let linux = System { os: "linux", ..System::default() };
        let text = report(&linux, &[]);
        assert!(text.contains("Vulkan loader   none") && text.contains("  none\n"), "{text}");

        let nvidia = System {
            os: "linux",
            devices: vec!["/dev/nvidia0".into()],
            loader: Some("/usr/lib/libvulkan.so.1".into()),
            ..System::default()
        };
        let text = report(&nvidia, &[llvmpipe()]);
        assert!(text.contains("A GPU of this machine may not be used") && text.contains("NVIDIA"), "{text}");
        let text = report(&nvidia, &[works("A")]);
        assert!(text.contains("All is well"), "{text}");
        let elsewhere = System { variable: Some("VK_DRIVER_FILES"), ..nvidia };
        assert!(report(&elsewhere, &[]).contains("VK_DRIVER_FILES"));
        let text = report(&windows(), &[]);
        assert!(text.contains("Vulkan loader   none\nDirect3D 12     none\n"), "{text}");
    }

    #[test]
    fn the_report_says_what_each_device_did() {
        let old = "it is less than WebGPU asks of a device: its x is 1, not 2";
        let text = report(&windows(), &[works("A 1"), tried("B", "Vulkan", false, Some(old))]);
        assert!(text.contains("  A 1 (Vulkan, Mesa): a test picture in 1.2 s\n"), "{text}");
        assert!(
            text.contains(&format!("Cannot render: B (Vulkan, Mesa): {old}\n  A newer driver")),
            "{text}"
        );
        assert!(text.contains("but not by every GPU") && !text.contains("All is well"), "{text}");
        // The CPU does what an old one cannot: whether there is one need not be asked.
        let text = report(&windows(), &[llvmpipe(), tried("B", "Vulkan", false, Some(old))]);
        assert!(text.contains("on the CPU") && !text.contains("If this machine has a GPU"), "{text}");

        let two_ways = [works("A"), works("B 2"), tried("A", "Dx12", false, None)];
        let text = report(&windows(), &two_ways);
        assert!(text.contains("several GPUs: --gpu \"B 2\""), "{text}");
        assert!(!report(&windows(), &[works("A"), tried("A", "Dx12", false, None)]).contains("several"));

        let remote = System { is_remote: true, ..windows() };
        let text = report(&remote, &[llvmpipe()]);
        assert!(text.contains("on the CPU") && text.contains("remote desktop"), "{text}");
    }

    /// Wine 8 shows a card that is none, by a Direct3D that cannot compile: a bug of ours was to be reported.
    #[test]
    fn what_fails_by_direct3d_alone_is_told_in_plain_words() {
        let reason = "it fails at a first kernel: FXC D3DCompile error\n\nCaused by:\n  Not implemented.\n";
        let card = |name| tried(name, "Dx12", false, Some(reason));
        let wine = System { is_wine: true, ..windows() };
        let text = report(&wine, &[llvmpipe(), card("GTX 470")]);
        assert!(
            text.contains("a first kernel: FXC D3DCompile error: Not implemented.\n  Wine's Direct3D"),
            "{text}"
        );
        assert!(text.contains("windows") && text.contains(", in Wine\n"), "{text}");
        assert!(text.ends_with("Rendering works, on the CPU, and is slow.\n"), "{text}");
        let text = report(&windows(), &[works("A"), card("A")]);
        assert!(text.contains("nothing is lost") && text.contains("All is well"), "{text}");
        let text = report(&windows(), &[llvmpipe(), card("A")]);
        assert!(text.contains("d3dcompiler_47.dll"), "{text}");
        let text = report(&windows(), &[tried("A", "Dx12", false, None)]);
        assert!(text.contains("Only Direct3D is there"), "{text}");
    }

    #[test]
    fn what_windows_blocks_is_told() {
        assert!(!report(&windows(), &[works("A")]).contains("Unblock-File"));
        assert!(report(&System { is_marked: true, ..windows() }, &[works("A")]).contains("Unblock-File"));
    }
}

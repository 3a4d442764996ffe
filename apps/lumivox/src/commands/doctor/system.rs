//! What can be seen of GPUs without asking a graphics API, and what to do where they cannot be used.

use std::{
    borrow::Cow,
    fs,
    path::{Path, PathBuf},
};

#[derive(Debug, Default)]
pub struct System {
    pub os: &'static str,
    /// Device files of GPUs.
    pub devices: Vec<PathBuf>,
    /// Those of them that this person may not open.
    pub closed: Vec<PathBuf>,
    /// The Vulkan loader, where there is one.
    pub loader: Option<PathBuf>,
    /// Manifests of Vulkan drivers.
    pub drivers: Vec<PathBuf>,
    /// The variable that makes the Vulkan loader look elsewhere for drivers, where one is set.
    pub variable: Option<&'static str>,
    /// Windows' library of Direct3D 12, where there is one.
    pub direct3d: Option<PathBuf>,
    /// Whether somebody sees this desktop from another machine.
    pub is_remote: bool,
    /// Whether this Windows is Wine's.
    pub is_wine: bool,
    /// Whether Windows remembers that this program came from the web.
    pub is_marked: bool,
}

impl System {
    pub fn look() -> Self {
        let mut system = Self { os: std::env::consts::OS, ..Self::default() };
        match system.os {
            "linux" => system.look_at_linux(),
            "windows" => system.look_at_windows(),
            _ => {}
        }
        let set = |name: &&str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        system.variable =
            ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].into_iter().find(set).filter(|_| system.os != "macos");
        system
    }

    fn look_at_linux(&mut self) {
        self.devices = files_in(Path::new("/dev/dri"), |name| name.starts_with("renderD"));
        self.devices.extend(files_in(Path::new("/dev"), |name| name == "dxg" || name == "nvidia0"));
        let is_closed = |path: &&PathBuf| {
            let opened = fs::OpenOptions::new().read(true).write(true).open(path);
            opened.is_err_and(|error| error.kind() == std::io::ErrorKind::PermissionDenied)
        };
        self.closed = self.devices.iter().filter(is_closed).cloned().collect();
        let libraries = ["/usr/lib", "/usr/lib64", "/lib", "/usr/local/lib"].map(PathBuf::from);
        let multiarch = libraries[0].join(format!("{}-linux-gnu", std::env::consts::ARCH));
        self.loader = std::iter::once(multiarch)
            .chain(libraries)
            .map(|folder| folder.join("libvulkan.so.1"))
            .find(|path| path.exists());
        for folder in ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"] {
            self.drivers.extend(files_in(Path::new(folder), |name| name.ends_with(".json")));
        }
    }

    fn look_at_windows(&mut self) {
        let root = std::env::var_os("SystemRoot").map_or_else(|| PathBuf::from(r"C:\Windows"), PathBuf::from);
        let system = |name: &str| Some(root.join("System32").join(name)).filter(|path| path.exists());
        self.loader = system("vulkan-1.dll");
        self.direct3d = system("d3d12.dll");
        self.is_wine = system("winecfg.exe").is_some();
        // Windows names a session at the machine itself 'Console'.
        self.is_remote =
            std::env::var("SESSIONNAME").is_ok_and(|name| name.to_uppercase().starts_with("RDP-"));
        let mark = std::env::current_exe().and_then(|program| {
            let mut mark = program.into_os_string();
            mark.push(":Zone.Identifier");
            fs::read_to_string(mark)
        });
        self.is_marked = mark.is_ok_and(|mark| is_from_the_web(&mark));
    }

    /// What to do when nothing can render, or when only software can though there is a GPU.
    pub fn remedy(&self) -> Cow<'static, str> {
        if let (Some(variable), true) = (self.variable, self.loader.is_some()) {
            return format!("{variable} is set, so that only the drivers it names are used: unset it").into();
        }
        if let [device, ..] = &self.closed[..] {
            return format!(
                "You may not open {}: sudo usermod -aG render,video \"$USER\", then log in anew; in a container, it has to \
                 be handed on",
                device.display()
            )
            .into();
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
            "windows" if self.is_wine => {
                "This is Wine, which renders by the Vulkan drivers of the system that it runs on: install those there \
                 (Debian, Ubuntu, Fedora: mesa-vulkan-drivers)"
            }
            "windows" => "Install the graphics driver of the GPU's maker: Vulkan or Direct3D 12 is needed",
            "macos" => "Metal is needed: macOS 10.14 or later on a Mac of 2012 or later",
            _ => "Vulkan, Direct3D 12 or Metal is needed",
        })
    }

    /// Why there may be no GPU where only the CPU renders; `None` where none is to be expected.
    pub fn why_no_gpu(&self) -> Option<String> {
        if self.variable.is_some() || self.is_remote || !self.devices.is_empty() {
            return Some(format!("A GPU of this machine may not be used. {}.", self.remedy()));
        }
        match self.os {
            "linux" => Some(
                "No GPU is seen in /dev. Where there is one: in a container, hand it on (docker run --device /dev/dri, or \
                 --gpus all); else install its driver."
                    .to_owned(),
            ),
            "windows" if !self.is_wine => {
                Some(format!("If this machine has a GPU: {}.", lower(&self.remedy())))
            }
            _ => None,
        }
    }
}

/// What Windows writes beside a file that was downloaded, or unpacked from such a one: zone 3 is the web, 4 what is not trusted.
fn is_from_the_web(mark: &str) -> bool {
    mark.lines().any(|line| matches!(line.trim(), "ZoneId=3" | "ZoneId=4"))
}

/// To follow a colon.
fn lower(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

fn files_in(folder: &Path, wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(&wanted))
        .map(|entry| entry.path())
        .collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_helps_is_what_is_missing_here() {
        let linux = || System { os: "linux", ..System::default() };
        let with_loader = || System { loader: Some("/usr/lib/libvulkan.so.1".into()), ..linux() };
        assert!(linux().remedy().contains("libvulkan1"));
        assert!(with_loader().remedy().starts_with("Install Vulkan drivers"));
        let nvidia = System { devices: vec!["/dev/nvidia0".into()], ..with_loader() };
        assert!(nvidia.remedy().contains("NVIDIA's driver"));
        let closed = System { closed: vec!["/dev/dri/renderD128".into()], ..with_loader() };
        assert!(closed.remedy().contains("may not open /dev/dri/renderD128"));
        let elsewhere = System { variable: Some("VK_DRIVER_FILES"), ..nvidia };
        assert!(elsewhere.remedy().contains("VK_DRIVER_FILES is set"));

        let windows = || System { os: "windows", ..System::default() };
        assert!(windows().remedy().contains("driver of the GPU's maker"));
        assert!(System { is_remote: true, ..windows() }.remedy().contains("remote desktop"));
        assert!(System { is_wine: true, ..windows() }.remedy().contains("Wine"));
    }

    #[test]
    fn a_gpu_that_should_be_there_is_asked_after() {
        let of = |system: System| system.why_no_gpu().unwrap_or_default();
        let linux = || System { os: "linux", loader: Some("libvulkan.so.1".into()), ..System::default() };
        assert!(of(linux()).contains("--device /dev/dri"));
        let with_device = System { devices: vec!["/dev/dri/renderD128".into()], ..linux() };
        assert!(of(with_device).starts_with("A GPU of this machine may not be used. Install Vulkan drivers"));
        let windows = || System { os: "windows", ..System::default() };
        assert!(of(windows()).starts_with("If this machine has a GPU: install the graphics driver"));
        assert_eq!(of(System { is_wine: true, ..windows() }), "");
        assert!(of(System { is_remote: true, ..windows() }).contains("remote desktop"));
    }

    #[test]
    fn windows_marks_what_came_from_the_web() {
        assert!(is_from_the_web("[ZoneTransfer]\r\nZoneId=3\r\nHostUrl=https://example.org/a.zip\r\n"));
        assert!(!is_from_the_web("[ZoneTransfer]\r\nZoneId=1\r\n"));
        assert!(!is_from_the_web(""));
    }
}

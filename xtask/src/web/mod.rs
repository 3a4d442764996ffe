//! What is for browsers, the Studio's page, the npm package and kernels: served on this machine, and tried in a browser.

mod browser;
mod kernels;
mod npm;
mod serve;
mod trial;

use std::path::Path;

pub use kernels::Texts;
pub use serve::serve;
pub use trial::Extent;

/// Opens a page's folder in a browser that nobody sees, and does what a person would, or first; pictures of it go to a folder.
pub fn test(
    extent: Extent,
    folder: &Path,
    browser: &Path,
    scan: &Path,
    pictures: &Path,
) -> Result<(), String> {
    trial::run(extent, folder, browser, scan, pictures)
}

/// The same with the npm package, as a program would use it.
pub fn test_npm(folder: &Path, browser: &Path, scan: &Path, pictures: &Path) -> Result<(), String> {
    npm::run(folder, browser, scan, pictures)
}

/// Has a browser's compiler judge every kernel that browsers may be given.
pub fn test_kernels(texts: Texts, browser: &Path) -> Result<(), String> {
    kernels::run(texts, browser)
}

#[cfg(all(test, unix))]
mod tests {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::process::{Command, Output};

    use super::*;

    /// Makes a page by the script, of programs that only write what they would.
    fn make(tools: &Path, out: &Path) -> Output {
        let script = ". script/lib.sh && . script/wasm.sh && . script/web.sh && need_wasm_rust() { :; } && \
                      target_folder() { echo \"$LUMIVOX_WEB_TOOLS\"; } && make_page \"$1\"";
        let mut command = Command::new("bash");
        command.args(["-euc", script, "bash"]).arg(out).current_dir(crate::root().unwrap());
        command.env("LUMIVOX_WEB_TOOLS", tools).env("CARGO", "true").output().unwrap()
    }

    #[test]
    fn a_page_is_made_whole_or_not_at_all() {
        let folder = std::env::temp_dir().join(format!("lumivox-page-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        let [tools, out, other] = ["tools", "a page", "other"].map(|name| folder.join(name));
        fs::create_dir_all(&tools).unwrap();
        let program = |name: &str, text: &str| {
            let file = tools.join(name);
            fs::write(&file, format!("#!/bin/sh\n{text}\n")).unwrap();
            fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
        };
        let version = fs::read_to_string(crate::root().unwrap().join("script/web.sh")).unwrap();
        let version = version.split_once("WASM_BINDGEN_VERSION=").unwrap().1.lines().next().unwrap();
        program(
            "wasm-bindgen",
            &format!(
                "[ \"$1\" != --version ] || exec echo 'wasm-bindgen {version}'\necho one >\"$5/lumivox_studio_bg.wasm\""
            ),
        );
        program("wasm-ld", "");
        let small = "[ \"$1\" = --version ] || { for file; do :; done; echo small >\"$file\"; }";
        program("wasm-opt", small);

        let made = make(&tools, &out);
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        let wasm = || fs::read_to_string(out.join("lumivox_studio_bg.wasm")).unwrap();
        assert_eq!(wasm(), "small\n");
        let offline = fs::read_to_string(out.join("offline.js")).unwrap();
        assert!(!offline.contains("VERSION"), "{offline}");
        // What is left of an older page goes, when the new one is whole.
        fs::write(out.join("old.js"), "").unwrap();
        program("wasm-opt", "[ \"$1\" = --version ]");
        assert!(!make(&tools, &out).status.success());
        assert!(out.join("old.js").exists() && wasm() == "small\n");
        program("wasm-opt", &small.replace("small", "smaller"));
        assert!(make(&tools, &out).status.success());
        assert!(!out.join("old.js").exists() && wasm() == "smaller\n");
        // Nothing else is touched: the page's own sources have its names.
        fs::create_dir(&other).unwrap();
        fs::copy(out.join("studio.js"), other.join("studio.js")).unwrap();
        let refused = make(&tools, &other);
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(!refused.status.success() && said.contains("holds something else"), "{said}");
        assert_eq!(fs::read_dir(&other).unwrap().count(), 1);
        let left = fs::read_dir(&tools).unwrap().count();
        assert_eq!(left, 3, "nothing is left beside the tools");
        fs::remove_dir_all(&folder).unwrap();
    }
}

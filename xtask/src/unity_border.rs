//! The C# half of Unity's border, made of the Rust half: the structs and enums of `abi.rs`, and every function that
//! crosses. What rustfmt leaves of them is read line by line; what is written otherwise is an error, never passed over.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const SOURCES: &str = "crates/lumivox-unity/src";
const STRUCTS: &str = "unity/com.lumivox/Runtime/Native/Abi.cs";
const FUNCTIONS: &str = "unity/com.lumivox/Runtime/Native/Library.cs";

/// Those with functions, in the order in which the header has them.
const FILES: [&str; 11] =
    ["border", "volume", "look", "labels", "jobs", "scene", "scene_light", "saving", "steps", "stage", "abi"];

/// What has another name in C#, where Unity or the package has one already.
const NAMES: [(&str, &str); 5] = [
    ("LumivoxEnvironment", "Surroundings"),
    ("LumivoxJobState", "JobState"),
    ("LumivoxLabel", "LabelInfo"),
    ("LumivoxLight", "LightSource"),
    ("LumivoxPose", "ObjectPose"),
];

/// Writes both files.
pub fn write() -> Result<(), String> {
    let root = crate::root()?;
    for (path, text) in made(&root)? {
        fs::write(root.join(path), text).map_err(|error| format!("cannot write {path}: {error}"))?;
    }
    Ok(())
}

/// Compares what is committed with what would be written.
pub fn check() -> Result<(), String> {
    let root = crate::root()?;
    for (path, text) in made(&root)? {
        // Git may check files out with other ends of lines.
        let there = fs::read_to_string(root.join(path)).unwrap_or_default().replace("\r\n", "\n");
        if there != text {
            return Err(format!(
                "{path} is stale: run `cargo xtask unity-border`, and commit what it writes"
            ));
        }
    }
    println!("Unity's border is the library's");
    Ok(())
}

fn made(root: &Path) -> Result<[(&'static str, String); 2], String> {
    let read = |file: &str| {
        let path = root.join(SOURCES).join(format!("{file}.rs"));
        fs::read_to_string(&path).map_err(|error| format!("cannot read {}: {error}", path.display()))
    };
    let abi = read("abi")?;
    let types = types(&abi)?;
    let mut functions = vec![];
    for file in FILES {
        let text = read(file)?;
        let found = functions_of(&text).map_err(|error| format!("{SOURCES}/{file}.rs: {error}"))?;
        functions.extend(found);
        if let Some(name) = unguarded(&text).first() {
            return Err(format!(
                "{SOURCES}/{file}.rs: a panic in {name} would end its host: have `guard` of border.rs, or one of its kind, \
                 catch it"
            ));
        }
    }
    Ok([(STRUCTS, structs(&abi, &types)?), (FUNCTIONS, library(&functions, &types)?)])
}

/// A struct or an enum of the border.
#[derive(Debug, PartialEq)]
struct Type {
    name: String,
    is_enum: bool,
    docs: Vec<String>,
    /// Each with its docs, and its type or its value.
    members: Vec<(Vec<String>, String, String)>,
}

/// All that `abi.rs` declares.
fn types(abi: &str) -> Result<Vec<Type>, String> {
    let mut found: Vec<Type> = vec![];
    let (mut docs, mut open, mut is_c) = (vec![], false, false);
    for line in abi.lines() {
        let text = line.trim();
        if let Some(doc) = text.strip_prefix("///") {
            docs.push(doc.trim().to_owned());
        } else if let Some(rest) = text.strip_prefix("pub struct ").or_else(|| text.strip_prefix("pub enum "))
        {
            let name = rest.strip_suffix(" {").ok_or_else(|| format!("abi.rs: not understood: {text}"))?;
            if !is_c {
                return Err(format!("abi.rs: {name} is not #[repr(C)]"));
            }
            let is_enum = text.starts_with("pub enum");
            found.push(Type {
                name: name.to_owned(),
                is_enum,
                docs: std::mem::take(&mut docs),
                members: vec![],
            });
            (open, is_c) = (true, false);
        } else if text == "}" {
            open = false;
        } else if open && !text.is_empty() {
            let of = found.last_mut().expect("one is open");
            let (name, what) = match of.is_enum {
                true => text.strip_suffix(',').and_then(|text| text.split_once(" = ")),
                false => text
                    .strip_suffix(',')
                    .and_then(|text| text.strip_prefix("pub "))
                    .and_then(|text| text.split_once(": ")),
            }
            .ok_or_else(|| format!("abi.rs: not understood: {text}"))?;
            of.members.push((std::mem::take(&mut docs), name.to_owned(), what.to_owned()));
        } else {
            is_c |= text == "#[repr(C)]";
            if !text.starts_with("#[") {
                docs.clear();
            }
        }
    }
    Ok(found)
}

/// A function of the border: its name, its parameters, and what it gives.
#[derive(Debug, PartialEq)]
struct Function {
    name: String,
    parameters: Vec<(String, String)>,
    gives: Option<String>,
}

/// All that a file exports.
fn functions_of(text: &str) -> Result<Vec<Function>, String> {
    let mut found = vec![];
    for (at, _) in text.match_indices("extern \"C\" fn ") {
        let rest = &text[at + "extern \"C\" fn ".len()..];
        let head = rest.split_once(" {").ok_or("a function without a body")?.0;
        let head = head.split_whitespace().collect::<Vec<_>>().join(" ");
        let wrong = || format!("not understood: {head}");
        let (name, rest) = head.split_once('(').ok_or_else(wrong)?;
        let (parameters, gives) = rest.rsplit_once(')').ok_or_else(wrong)?;
        let parameter = |text: &str| {
            let (name, of) = text.split_once(": ").ok_or_else(wrong)?;
            Ok((name.trim().to_owned(), of.trim().to_owned()))
        };
        let parameters = parameters.split(',').map(str::trim).filter(|text| !text.is_empty());
        found.push(Function {
            name: name.to_owned(),
            parameters: parameters.map(parameter).collect::<Result<_, String>>()?,
            gives: gives.trim().strip_prefix("-> ").map(str::to_owned),
        });
    }
    Ok(found)
}

/// What catches panics: guards, and what stands on them.
const GUARDS: [&str; 3] = ["guard", "free(", "take("];
/// What cannot panic: constants.
const CONSTANT: [&str; 2] = ["lumivox_abi_version", "lumivox_version"];

/// Functions that a file exports, and out of which a panic would go on into C#, where nothing can be done about it.
fn unguarded(text: &str) -> Vec<&str> {
    let functions = text
        .split("extern \"C\" fn ")
        .skip(1)
        .map(|rest| rest.split_once("\n}").map_or(rest, |(body, _)| body));
    let named = functions.map(|function| function.split_once('(').unwrap_or((function, "")));
    named
        .filter(|(name, body)| !CONSTANT.contains(name) && !GUARDS.iter().any(|guard| body.contains(guard)))
        .map(|(name, _)| name)
        .collect()
}

/// What a type of the border is called in C#.
fn name_of(own: &str) -> &str {
    let other = NAMES.iter().find(|(name, _)| *name == own).map(|(_, other)| *other);
    other.unwrap_or_else(|| own.strip_prefix("Lumivox").unwrap_or(own))
}

/// A number, as C# has it.
fn number(rust: &str) -> Option<&'static str> {
    Some(match rust {
        "u8" => "byte",
        "u32" => "uint",
        "i32" => "int",
        "u64" => "ulong",
        "f32" => "float",
        "f64" => "double",
        _ => return None,
    })
}

/// A type as C# has it; whether it stands in a struct or is a parameter, or given by the function.
fn type_of(rust: &str, types: &[Type], is_given: bool) -> Result<String, String> {
    if let Some(known) = number(rust) {
        return Ok(known.to_owned());
    }
    if let Some(known) = types.iter().find(|of| of.name == rust) {
        return Ok(name_of(&known.name).to_owned());
    }
    let to = rust.strip_prefix("*const ").or_else(|| rust.strip_prefix("*mut "));
    let to = to.ok_or_else(|| format!("C# has no word for {rust}"))?;
    // Of a path the type is its last part.
    let to = if to.starts_with('*') { to } else { to.rsplit("::").next().unwrap_or(to) };
    Ok(match to {
        // Strings of the library's are its own.
        "c_char" if is_given => "IntPtr".to_owned(),
        "c_char" => "byte*".to_owned(),
        "c_void" => "void*".to_owned(),
        _ if to.starts_with('*') => format!("{}*", type_of(to, types, false)?),
        _ if number(to).is_some() || types.iter().any(|of| of.name == to) => {
            format!("{}*", type_of(to, types, false)?)
        }
        // A handle.
        _ if to.starts_with("Lumivox") => "IntPtr".to_owned(),
        _ => return Err(format!("C# has no word for {rust}")),
    })
}

/// `world_from_camera` as C# has it.
fn camel(snake: &str) -> String {
    let mut out = String::new();
    for (index, word) in snake.split('_').enumerate() {
        let mut letters = word.chars();
        let first = letters.next().into_iter();
        out.extend(first.map(|letter| if index == 0 { letter } else { letter.to_ascii_uppercase() }));
        out.push_str(letters.as_str());
    }
    match out.as_str() {
        "out" | "in" | "ref" | "params" => format!("@{out}"),
        _ => out,
    }
}

/// A field of a struct; whether it makes the struct unsafe.
fn field(name: &str, rust: &str, types: &[Type]) -> Result<(String, bool), String> {
    let name = camel(name);
    if let Some(array) = rust.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        let (of, count) = array.split_once("; ").ok_or_else(|| format!("not understood: {rust}"))?;
        return Ok(match (of, count) {
            ("f32", "3") => (format!("Vector3 {name}"), false),
            ("f32", "4") => (format!("Quaternion {name}"), false),
            ("f32", "16") => (format!("Matrix4x4 {name}"), false),
            _ => {
                let of = number(of).ok_or_else(|| format!("C# has no word for {rust}"))?;
                (format!("fixed {of} {name}[{count}]"), true)
            }
        });
    }
    let of = type_of(rust, types, false)?;
    let is_unsafe = of.ends_with('*');
    Ok((format!("{of} {name}"), is_unsafe))
}

/// A comment that C# reads.
fn summary(docs: &[String], indent: &str) -> String {
    let text = docs.join(" ").replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    format!("{indent}/// <summary>{text}</summary>\n")
}

const HEADER: &str = "// Made by `cargo xtask unity-border` of crates/lumivox-unity.\n";

fn structs(abi: &str, types: &[Type]) -> Result<String, String> {
    let version = abi
        .lines()
        .find_map(|line| line.strip_prefix("pub const LUMIVOX_ABI_VERSION: u32 = ")?.strip_suffix(';'))
        .ok_or("abi.rs: there is no LUMIVOX_ABI_VERSION")?;
    let mut text = format!(
        "{HEADER}using System;\nusing System.Runtime.InteropServices;\nusing UnityEngine;\n\nnamespace Lumivox.Native\n{{\n"
    );
    let mut body = String::new();
    for of in types {
        let name = name_of(&of.name);
        if of.is_enum {
            write!(body, "\n{}    internal enum {name} : uint\n    {{\n", summary(&of.docs, "    "))
                .expect("text");
            for (docs, member, value) in &of.members {
                writeln!(body, "{}        {member} = {value},", summary(docs, "        ")).expect("text");
            }
        } else {
            let mut fields = String::new();
            let mut is_unsafe = false;
            for (docs, member, rust) in &of.members {
                let (field, needs_it) =
                    field(member, rust, types).map_err(|error| format!("{}: {error}", of.name))?;
                is_unsafe |= needs_it;
                writeln!(fields, "{}        public {field};", summary(docs, "        ")).expect("text");
            }
            let modifier = if is_unsafe { "unsafe " } else { "" };
            write!(
                body,
                "\n{}    [StructLayout(LayoutKind.Sequential)]\n    internal {modifier}partial struct {name}\n    {{\n{fields}",
                summary(&of.docs, "    ")
            )
            .expect("text");
        }
        body.push_str("    }\n");
    }
    let sizes: Vec<String> = types
        .iter()
        .filter(|of| !of.is_enum)
        .map(|of| format!("            (uint)sizeof({}),\n", name_of(&of.name)))
        .collect();
    write!(
        text,
        "    /// <summary>What the library and this package must have in common.</summary>\n    \
             internal static unsafe class Abi\n    {{\n        \
                 /// <summary>Raised with the library's own.</summary>\n        \
                 public const uint Version = {version};\n\n        \
                 /// <summary>Bytes of the structs, in their order.</summary>\n        \
                 public static uint[] Sizes => new[]\n        {{\n{}        }};\n    }}\n{body}}}\n",
        sizes.concat()
    )
    .expect("text");
    Ok(text)
}

fn library(functions: &[Function], types: &[Type]) -> Result<String, String> {
    let mut text = format!(
        "{HEADER}using System;\nusing System.Runtime.InteropServices;\n\nnamespace Lumivox.Native\n{{\n    \
             /// <summary>The native library's functions, as its header declares them.</summary>\n    \
             internal static unsafe class Library\n    {{\n\
         #if (UNITY_IOS || UNITY_TVOS || UNITY_VISIONOS || UNITY_WEBGL) && !UNITY_EDITOR\n        \
                 public const string Name = \"__Internal\";\n\
         #else\n        \
                 public const string Name = \"lumivox_unity\";\n\
         #endif\n\n"
    );
    for Function { name, parameters, gives } in functions {
        let wrong = |error| format!("{name}: {error}");
        let gives = match gives {
            Some(rust) => type_of(rust, types, true).map_err(wrong)?,
            None => "void".to_owned(),
        };
        let parameters = parameters
            .iter()
            .map(|(parameter, rust)| Ok(format!("{} {}", type_of(rust, types, false)?, camel(parameter))))
            .collect::<Result<Vec<_>, String>>()
            .map_err(wrong)?;
        writeln!(
            text,
            "        [DllImport(Name)] public static extern {gives} {name}({});",
            parameters.join(", ")
        )
        .expect("text");
    }
    text.push_str("    }\n}\n");
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_is_current() {
        check().unwrap();
    }

    const ABI: &str = "pub const LUMIVOX_ABI_VERSION: u32 = 3;\n\n/// A < place.\n#[repr(C)]\npub struct LumivoxPose {\n    \
        /// Metres.\n    pub position: [f32; 3],\n    /// So many.\n    pub counts: [u32; 2],\n    \
        /// A handle.\n    pub map: *const crate::look::LumivoxMap,\n}\n\n/// How far.\n#[repr(C)]\npub enum LumivoxJobState {\n    \
        /// It is.\n    Done = 1,\n}\n";

    #[test]
    fn structs_have_unitys_types() {
        let made = structs(ABI, &types(ABI).unwrap()).unwrap();
        for part in [
            "public const uint Version = 3;",
            "(uint)sizeof(ObjectPose),\n        };",
            "/// <summary>A &lt; place.</summary>",
            "internal unsafe partial struct ObjectPose\n",
            "public Vector3 position;",
            "public fixed uint counts[2];",
            "public IntPtr map;",
            "internal enum JobState : uint\n",
            "Done = 1,",
        ] {
            assert!(made.contains(part), "{part} is not in {made}");
        }
    }

    /// A panic that reaches C# ends the program there, in Unity the editor.
    #[test]
    fn functions_that_catch_no_panic_are_found() {
        let source = "pub unsafe extern \"C\" fn lumivox_a(index: u32) -> u32 {\n    guard(|| Ok(TEXTS[index])).unwrap_or(0)\n}\n\n\
            /// As guard( does not.\npub extern \"C\" fn lumivox_b(index: u32) -> u32 {\n    TEXTS[index]\n}\n\n\
            pub unsafe extern \"C\" fn lumivox_c(map: *mut Map) {\n    unsafe { free(map) };\n}\n\n\
            pub extern \"C\" fn lumivox_version() -> u32 {\n    3\n}\n";
        assert_eq!(unguarded(source), ["lumivox_b"]);
    }

    #[test]
    fn functions_have_their_parameters() {
        let source = "pub unsafe extern \"C\" fn lumivox_a(\n    pose: *mut LumivoxPose,\n    out: *const *const std::ffi::c_char,\n    \
            of: *const LumivoxStage,\n) -> *const c_char {\n}\npub extern \"C\" fn lumivox_b() {\n}\n";
        let made = library(&functions_of(source).unwrap(), &types(ABI).unwrap()).unwrap();
        assert!(made.contains("IntPtr lumivox_a(ObjectPose* pose, byte** @out, IntPtr of);"), "{made}");
        assert!(made.contains("void lumivox_b();"), "{made}");
    }

    #[test]
    fn what_is_not_known_is_an_error() {
        assert!(types("pub struct LumivoxA {\n}\n").unwrap_err().contains("#[repr(C)]"));
        let odd = "#[repr(C)]\npub struct LumivoxA {\n    pub a: usize,\n}\n";
        assert!(structs(&format!("{ABI}{odd}"), &types(odd).unwrap()).unwrap_err().contains("usize"));
    }
}

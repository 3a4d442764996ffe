//! Every kernel that a browser may be given, before the compiler of one: Chromium's refuses what naga lets pass, and that a text costs
//! a GPU's process its life is seen nowhere else.
//!
//! Its front end reads texts. What makes programs of them, Chromium's and then the driver's, here a processor in a GPU's place, takes
//! seconds for a path tracer: it is given some of each kind.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use lumivox_renderer::{DeviceLimits, Features, FineTexels, ViewKind};
use lumivox_shaders::{BindingKind, Classes, Kernel, KernelKind};
use serde_json::{Value, json};

use super::browser::Browser;
use super::serve::{Served, answer_all, listen};

/// The page that asks the browser.
const PAGE: &str = "xtask/src/web/kernels";
/// A browser that begins, and texts that are read, take no longer on a processor that others want, too.
const PATIENCE: Duration = Duration::from_secs(120);
/// Nor does what one kernel is made into: it takes 1 to 3 s. One of which every function is copied to wherever it is called takes
/// minutes, and 100 MB of memory each second, which no browser has.
const LONGEST: Duration = Duration::from_secs(60);
/// Texts that the page is given at once, half a MiB of them or so.
const TEXTS: usize = 8;
/// Browsers that are begun again after they have lost their device. Where there are more, all kernels are wrong.
const MOST_LOSSES: usize = 8;
/// Kernels that are named of those that are refused with the same words.
const MOST_NAMES: usize = 5;

/// Kernels by name.
type Kernels = BTreeMap<String, Kernel>;

/// Which texts are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Texts {
    /// Those of [`Kernel::all`], as in other tests of all kernels.
    Usual,
    /// Every set of constants that there is, fifteen times as many.
    Every,
}

/// Has a browser compile them, and says what it refuses.
pub fn run(texts: Texts, program: &Path) -> Result<(), String> {
    let begin = Instant::now();
    let made = made();
    let read = read(texts, &made);
    let (listener, address) = listen(0)?;
    let served = Arc::new(Served::of(&crate::root()?.join(PAGE))?);
    thread::spawn(move || answer_all(&listener, &served));
    let mut judge = Judge::new(program, address);
    let modules = judge.compile("modules", &read, TEXTS)?;
    println!(
        "kernels: {modules} of {} texts are read after {:.0} s",
        read.len(),
        begin.elapsed().as_secs_f64()
    );
    // What is refused already would be so once more, for no reason that tells anything.
    let made = made.into_iter().filter(|(name, _)| !judge.refused.holds(name)).collect();
    let pipelines = judge.compile("pipelines", &made, 1)?;
    let entry_points: BTreeSet<_> = read.values().map(|kernel| kernel.entry_point()).collect();
    let (kernels, took) = (entry_points.len(), begin.elapsed().as_secs_f64());
    let Judge { by, slowest: (longest, slowest), refused, .. } = judge;
    println!(
        "kernels: {kernels} kernels, {modules} modules, {pipelines} pipelines compiled by {by} in {took:.0} s"
    );
    println!("kernels: the slowest, {slowest}, took {:.1} s", longest.as_secs_f64());
    refused.outcome()?;
    // Of nothing nothing is refused.
    if modules == 0 || modules < read.len() || pipelines == 0 || pipelines < made.len() {
        return Err(format!("of {} modules and {} pipelines not all are compiled", read.len(), made.len()));
    }
    Ok(())
}

/// Views as programs in browsers have them.
const SHOWN: [ViewKind; 2] =
    [ViewKind::Live { guides: false, kept_light: true }, ViewKind::Still { guides: false }];
/// All others.
const OTHERS: [ViewKind; 4] = [
    ViewKind::Live { guides: false, kept_light: false },
    ViewKind::Live { guides: true, kept_light: false },
    ViewKind::Live { guides: true, kept_light: true },
    ViewKind::Still { guides: true },
];

/// How voxels are stored: by kernels of two kinds, for half floats are read as norms are.
const TEXELS: [FineTexels; 2] = [FineTexels::Norms, FineTexels::TwoBytes];

/// The kernels with which views of scenes that hold this are recorded in a browser.
fn of_browsers(
    scenes: impl IntoIterator<Item = Features>,
    views: &[ViewKind],
    texels: &[FineTexels],
) -> Kernels {
    // A host asks for that one, and no scene does.
    let mut kernels = HashSet::from([Kernel::CompositeVelocity]);
    for features in scenes {
        for fine_texels in texels {
            let limits = DeviceLimits::webgpu_default().with(|it| it.fine_texels = *fine_texels);
            kernels.extend(views.iter().flat_map(|view| features.kernels(*view, limits)));
        }
    }
    kernels.into_iter().map(|kernel| (kernel.name(), kernel)).collect()
}

/// Whether a browser may be given a kernel: `lumivox-wgpu` is told of no driver there that counts turns of loops, or that wants one pool.
fn is_for_browsers(kernel: Kernel) -> bool {
    match kernel {
        Kernel::PathTrace(variant) | Kernel::LightMarch(variant) => {
            !variant.limited_turns && !variant.one_pool
        }
        Kernel::ValueRanges { one_pool } => !one_pool,
        kernel => kernel != Kernel::SampleDirections,
    }
}

/// Kernels whose texts are read.
fn read(texts: Texts, made: &Kernels) -> Kernels {
    let mut kernels = made.clone();
    let views: Vec<_> = SHOWN.into_iter().chain(OTHERS).collect();
    match texts {
        Texts::Usual => kernels.extend(
            Kernel::all().filter(|kernel| is_for_browsers(*kernel)).map(|kernel| (kernel.name(), kernel)),
        ),
        Texts::Every => kernels.extend(of_browsers(Features::ALL.subsets(), &views, &TEXELS)),
    }
    kernels
}

/// Kernels that are made into programs, too: for scenes of nothing and of one thing each, in every view those of nothing. One for a
/// scene of everything a processor's driver makes in two minutes and 12 GiB of memory.
fn made() -> Kernels {
    let views: Vec<_> = SHOWN.into_iter().chain(OTHERS).collect();
    let none = Features::default();
    let one = [
        Features { environment: true, ..none },
        Features { surface: true, ..none },
        Features { filters: true, ..none },
        Features { lights: true, ..none },
        Features { many_volumes: true, ..none },
    ];
    let classes = Classes::sets().map(|classes| Features { classes, ..none });
    let mut kernels = of_browsers([none], &views, &TEXELS);
    // Voxels of which browsers have most.
    kernels.extend(of_browsers(one.into_iter().chain(classes), &SHOWN, &[FineTexels::TwoBytes]));
    kernels
}

/// What a kernel is to the page.
fn given(name: &str, kernel: Kernel) -> Value {
    let kind = match kernel.kind() {
        KernelKind::Compute => "compute",
        KernelKind::DrawColor => "color",
        KernelKind::DrawOver => "over",
        KernelKind::DrawDepth => "depth",
    };
    let bindings = kernel.bindings().iter().map(|kind| match kind {
        BindingKind::Uniform => "uniform",
        BindingKind::StorageRead => "read",
        BindingKind::StorageReadWrite => "write",
        BindingKind::Texture3d => "texture3d",
        BindingKind::Texture2dLoaded => "texture2d",
        BindingKind::LinearSampler => "sampler",
    });
    let bindings: Vec<_> = bindings.collect();
    json!({ "name": name, "text": kernel.wgsl(), "entry": kernel.entry_point(), "kind": kind, "bindings": bindings })
}

/// What the page tells of kernels.
struct Told {
    /// Of each that it came to what is wrong with it, and the line where.
    each: Vec<Vec<(String, Option<u64>)>>,
    /// What became of the device, or of the browser, at the one behind them.
    gone: String,
}

impl Told {
    fn of(value: &Value) -> Option<Self> {
        let refusal = |of: &Value| Some((of["what"].as_str()?.to_owned(), of["line"].as_u64()));
        let refusals = |of: &Value| of.as_array()?.iter().map(refusal).collect::<Option<Vec<_>>>();
        let each = value["each"].as_array()?.iter().map(refusals).collect::<Option<Vec<_>>>()?;
        let gone = value["gone"].as_str().unwrap_or("the browser comes to no end with it").to_owned();
        Some(Self { each, gone })
    }
}

/// Who is asked, and what came of it.
struct Judge<'a> {
    program: &'a Path,
    address: String,
    /// One that has its device still.
    open: Option<Browser>,
    /// What it calls itself.
    by: String,
    losses: usize,
    /// Of those that were asked about alone.
    slowest: (Duration, String),
    refused: Refused,
}

impl<'a> Judge<'a> {
    fn new(program: &'a Path, address: String) -> Self {
        let (by, slowest, refused) = Default::default();
        Self { program, address, open: None, by, losses: 0, slowest, refused }
    }

    /// Puts kernels before a function of the page, so many at once; says how many of them are compiled.
    fn compile(&mut self, function: &str, kernels: &Kernels, at_once: usize) -> Result<usize, String> {
        let kernels: Vec<_> = kernels.iter().map(|(name, kernel)| (name.as_str(), *kernel)).collect();
        kernels.chunks(at_once).map(|part| self.compile_part(function, part)).sum()
    }

    fn compile_part(&mut self, function: &str, mut part: &[(&str, Kernel)]) -> Result<usize, String> {
        let mut compiled = 0;
        while let Some(((first, _), others)) = part.split_first() {
            let begin = Instant::now();
            let outcome = self.call(function, part)?;
            if others.is_empty() && begin.elapsed() > self.slowest.0 {
                self.slowest = (begin.elapsed(), (*first).to_owned());
            }
            let told = match outcome {
                Ok(told) => told,
                Err(gone) if others.is_empty() => Told { each: vec![], gone },
                Err(_) => {
                    // The browser itself is gone, and has not said at which: asked of one after the other it will.
                    self.lose(&format!("one of {} from {first} on", part.len()))?;
                    let mut each = part.chunks(1).map(|one| self.compile_part(function, one));
                    return each.try_fold(compiled, |sum, more| more.map(|more| sum + more));
                }
            };
            let done = told.each.len().min(part.len());
            for ((name, _), refusals) in part.iter().zip(&told.each) {
                compiled += usize::from(refusals.is_empty());
                for (what, line) in refusals {
                    self.refused.add(name, what, *line);
                }
            }
            part = &part[done..];
            if let Some(((name, _), behind)) = part.split_first() {
                self.refused.add(name, &told.gone, None);
                self.lose(name)?;
                part = behind;
            }
        }
        Ok(compiled)
    }

    /// What the page tells, or what has become of the browser meanwhile.
    fn call(&mut self, function: &str, part: &[(&str, Kernel)]) -> Result<Result<Told, String>, String> {
        if self.open.is_none() {
            self.open = Some(self.begin()?);
        }
        let Some(browser) = &mut self.open else { return Err("there is no browser".to_owned()) };
        let given: Vec<_> = part.iter().map(|(name, kernel)| given(name, *kernel)).collect();
        let call = |what: &str| format!("import('/kernels.js').then(page => page.{what})");
        let whole = browser.evaluate_within(&call(&format!("{function}({})", json!(given))), LONGEST);
        // What takes too long has told of those before it.
        let value = whole.or_else(|_| browser.evaluate(&call("told()")));
        Ok(value.and_then(|value| Told::of(&value).ok_or_else(|| format!("the page tells {value}"))))
    }

    /// A browser with the page, and a device.
    fn begin(&mut self) -> Result<Browser, String> {
        let mut browser = Browser::start(self.program)?;
        browser.ask("Page.navigate", json!({ "url": self.address }))?;
        browser.wait("location.pathname === '/' && document.readyState === 'complete'", PATIENCE)?;
        let told = browser.evaluate("import('/kernels.js').then(page => page.begin())")?;
        let words = ["browser", "device"].map(|name| told[name].as_str().unwrap_or_default());
        self.by = words.join(" for ");
        Ok(browser)
    }

    /// What is asked next is asked of another browser.
    fn lose(&mut self, at: &str) -> Result<(), String> {
        self.open = None;
        self.losses += 1;
        println!("kernels: the browser has lost its device at {at}");
        if self.losses > MOST_LOSSES {
            self.refused.outcome()?;
            return Err(format!("{} browsers lost their devices", self.losses));
        }
        Ok(())
    }
}

/// What was refused: with which words which kernels.
#[derive(Default)]
struct Refused(BTreeMap<String, Vec<String>>);

impl Refused {
    fn add(&mut self, name: &str, what: &str, line: Option<u64>) {
        let at = line.map_or(String::new(), |line| format!(", line {line}"));
        self.0.entry(what.to_owned()).or_default().push(format!("{name}{at}"));
    }

    fn holds(&self, name: &str) -> bool {
        self.0.values().flatten().any(|told| told.split(',').next() == Some(name))
    }

    /// Variants are refused by the hundred for one reason, which is told once.
    fn outcome(&self) -> Result<(), String> {
        if self.0.is_empty() {
            return Ok(());
        }
        let mut text = String::from("kernels are refused:");
        for (what, names) in &self.0 {
            let more = names.len().saturating_sub(MOST_NAMES);
            let first = names[..names.len() - more].join("\n    ");
            let more = if more > 0 { format!("\n    and {more} others") } else { String::new() };
            text += &format!("\n  {what}\n    {first}{more}");
        }
        Err(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kernel_of_browsers_is_read_and_some_of_each_kind_are_made() {
        let made = made();
        let [usual, every] = [Texts::Usual, Texts::Every].map(|texts| read(texts, &made));
        assert!(every.values().all(|kernel| is_for_browsers(*kernel)));
        assert!(usual.keys().all(|name| every.contains_key(name)));
        assert!(every.len() > 10 * usual.len(), "{} and {}", every.len(), usual.len());
        let kinds = |of: &Kernels| of.values().map(|kernel| kernel.entry_point()).collect::<BTreeSet<_>>();
        assert_eq!(kinds(&made), kinds(&every));
    }

    #[test]
    fn what_is_refused_is_told_once_for_all_variants() {
        let mut refused = Refused::default();
        assert_eq!(refused.outcome(), Ok(()));
        for at in 0..8 {
            refused.add(
                &format!("path_trace_{at}"),
                "mixing '<<' and '|' requires parenthesis: x << 1u | y",
                Some(at),
            );
        }
        refused.add("display", "its GPU's process is gone", None);
        let why = refused.outcome().unwrap_err();
        assert!(why.contains("x << 1u | y\n    path_trace_0, line 0\n    path_trace_1, line 1\n"), "{why}");
        assert!(why.contains("\n    and 3 others") && !why.contains("path_trace_5"), "{why}");
        assert!(why.contains("gone\n    display"), "{why}");
        assert!(refused.holds("display") && refused.holds("path_trace_7") && !refused.holds("path_trace"));
    }

    #[test]
    fn what_the_page_tells_is_read() {
        let wrong =
            json!([{ "what": "unresolved value 'x'", "line": 3 }, { "what": "no layout", "line": null }]);
        let told = json!({ "each": [[], wrong], "gone": null });
        let told = Told::of(&told).unwrap();
        assert_eq!(
            told.each[1],
            [("unresolved value 'x'".to_owned(), Some(3)), ("no layout".to_owned(), None)]
        );
        assert!(told.each[0].is_empty() && told.gone.contains("no end"));
        assert!(Told::of(&json!({ "each": [7] })).is_none());
    }
}

//! What is given to a page has names, and no place: files that are dropped or chosen lie in folders of the page's own making. What
//! belongs together stays together, two of one name are told from each other, and a scene that is saved names files as they are called.

use std::collections::BTreeMap;
use std::ops::Bound;
use std::path::{Component, Path, PathBuf};

use lumivox_core::document::SceneDocument;

/// A file that is given.
#[derive(Clone, Debug)]
pub struct Given {
    /// Its name, with the folder that was given around it.
    pub path: String,
    /// Bytes.
    pub size: f64,
    /// When it was last changed, in ms.
    pub changed: f64,
}

impl Given {
    fn is_same(&self, other: &Self) -> bool {
        (self.size, self.changed) == (other.size, other.changed)
    }

    fn is_scene(&self) -> bool {
        !self.path.contains('/') && has_ending(&self.path, &["lumivox"])
    }

    /// The folder or file that it is, or is part of.
    fn top(&self) -> &str {
        self.path.split('/').next().unwrap_or_default()
    }
}

/// Headers whose samples lie in a file beside them.
const HEADERS: [&str; 3] = ["nhdr", "mhd", "hdr"];

fn has_ending(name: &str, endings: &[&str]) -> bool {
    let ending = Path::new(name).extension().unwrap_or_default();
    endings.iter().any(|known| ending.eq_ignore_ascii_case(known))
}

/// Where files of an arrival lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placed {
    /// What stands before each path: nothing, or a folder and `/`.
    pub before: String,
    /// What is opened: scenes first.
    pub tops: Vec<String>,
}

/// A folder of the page's.
#[derive(Default)]
struct Folder {
    /// By their paths.
    files: BTreeMap<String, Given>,
    /// Whether it is opened itself.
    is_whole: bool,
}

impl Folder {
    /// Files of a top, which lie beside each other by their paths.
    fn of_top<'a>(&'a self, top: &'a str) -> impl Iterator<Item = &'a Given> {
        let from = self.files.range::<str, _>((Bound::Included(top), Bound::Unbounded));
        let files = from.take_while(move |(path, _)| path.starts_with(top)).map(|(_, file)| file);
        files.filter(move |file| file.top() == top && !file.is_scene())
    }

    /// Whether these files are there, and no others.
    fn has<'a>(&self, own: impl Iterator<Item = &'a Given>, given: &[&Given]) -> bool {
        let is_given = |file: &&Given| self.files.get(&file.path).is_some_and(|known| known.is_same(file));
        own.count() == given.len() && given.iter().all(is_given)
    }
}

/// All that was given.
pub struct Arrivals {
    /// The first has no name.
    folders: Vec<(String, Folder)>,
    last: usize,
}

impl Default for Arrivals {
    fn default() -> Self {
        Self { folders: vec![Default::default()], last: 0 }
    }
}

impl Arrivals {
    /// Finds a place for files that come together. Several loose ones are opened as a folder is, in which headers find their
    /// samples; `apart` where each is asked for by itself.
    pub fn place(&mut self, given: &[Given], apart: bool) -> Placed {
        let scans: Vec<&Given> = given.iter().filter(|file| !file.is_scene()).collect();
        let loose = scans.iter().filter(|file| !file.path.contains('/')).count();
        let is_whole = loose > 1 && !apart;
        // Each with its files; opened as they came.
        let mut by_top: BTreeMap<&str, Vec<&Given>> = BTreeMap::new();
        let mut tops: Vec<&str> = vec![];
        for file in scans.iter().copied() {
            let files = by_top.entry(file.top()).or_default();
            if files.is_empty() {
                tops.push(file.top());
            }
            files.push(file);
        }
        // A scene is read once: another of its name may take its place.
        let is_there = |folder: &Folder| match is_whole {
            true => {
                folder.is_whole && folder.has(folder.files.values().filter(|file| !file.is_scene()), &scans)
            }
            false => by_top.iter().all(|(top, files)| folder.has(folder.of_top(top), files)),
        };
        let is_free = |folder: &Folder| {
            let has_room = |(top, files): (&&str, &Vec<&Given>)| {
                folder.of_top(top).next().is_none() || folder.has(folder.of_top(top), files)
            };
            !is_whole && by_top.iter().all(has_room)
        };
        // A scene that comes alone is one of what came last.
        let place = [self.last].into_iter().chain(0..self.folders.len());
        let place = place.into_iter().find(|place| is_there(&self.folders[*place].1));
        let place = place.or_else(|| is_free(&self.folders[0].1).then_some(0)).unwrap_or_else(|| {
            let folder = Folder { is_whole, ..Folder::default() };
            self.folders.push((self.name_besides(given), folder));
            self.folders.len() - 1
        });
        self.last = place;
        let (name, folder) = &mut self.folders[place];
        folder.files.extend(given.iter().map(|file| (file.path.clone(), file.clone())));
        let before = if name.is_empty() { String::new() } else { format!("{name}/") };
        let scenes = given.iter().filter(|file| file.is_scene()).map(|file| before.clone() + &file.path);
        let scans = match is_whole {
            true => vec![name.clone()],
            false => tops.iter().map(|top| before.clone() + top).collect(),
        };
        Placed { tops: scenes.chain(scans).collect(), before }
    }

    /// A name that nothing has that was given.
    fn name_besides(&self, given: &[Given]) -> String {
        let all = || self.folders.iter().flat_map(|(_, folder)| folder.files.values()).chain(given);
        let is_new = |name: &String| {
            all().all(|file| file.top() != name) && self.folders.iter().all(|(known, _)| known != name)
        };
        (1_u64..).map(|number| format!("<{number}>")).find(is_new).unwrap_or_default()
    }

    /// Has a document name files as they are called: whoever opens it gives them, too.
    ///
    /// # Errors
    /// A sentence, where two different ones have one name.
    pub fn name(&self, document: &mut SceneDocument) -> Result<(), String> {
        let mut named: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
        let mut name = |path: &Path| -> Result<Vec<PathBuf>, String> {
            let names = self.names(path);
            for (whole, name) in &names {
                let first = named.entry(name.clone()).or_insert_with(|| whole.clone());
                if first != whole {
                    let name = name.display();
                    return Err(format!(
                        "{name}: the scene is of two of that name; rename one, and open it again"
                    ));
                }
            }
            Ok(names.into_iter().map(|(_, name)| name).collect())
        };
        let one = |names: Vec<PathBuf>| names.into_iter().next().unwrap_or_default();
        for entry in &mut document.volumes {
            let mut all = |files: &mut Vec<PathBuf>| -> Result<(), String> {
                let names: Vec<_> = files.iter().map(|file| name(file)).collect::<Result<_, _>>()?;
                *files = names.concat();
                Ok(())
            };
            all(&mut entry.scan.files)?;
            if let Some(labels) = &mut entry.labels {
                all(&mut labels.files)?;
                if let Some(table) = &mut labels.table {
                    *table = one(name(table)?);
                }
            }
        }
        if let Some(map) = document.environment.file().map(&mut name).transpose()? {
            document.environment.source = one(map);
        }
        Ok(())
    }

    /// What a path is called, beside where that lies: of a folder of the page's own that is opened all that has to be named.
    fn names(&self, path: &Path) -> Vec<(PathBuf, PathBuf)> {
        let parts = || path.components().filter(|part| *part != Component::CurDir);
        let first = parts().next().map(|part| part.as_os_str().to_string_lossy().into_owned());
        let folder = self.folders.iter().skip(1).find(|(name, _)| Some(name) == first.as_ref());
        let Some((name, folder)) = folder else { return vec![(path.to_owned(), path.to_owned())] };
        let inner: PathBuf = parts().skip(1).collect();
        if !inner.as_os_str().is_empty() {
            return vec![(path.to_owned(), inner)];
        }
        let mut tops: Vec<&str> =
            folder.files.values().filter(|file| !file.is_scene()).map(Given::top).collect();
        tops.dedup();
        // Headers name their samples themselves.
        if tops.iter().any(|top| has_ending(top, &HEADERS)) {
            tops.retain(|top| has_ending(top, &HEADERS));
        }
        tops.into_iter().map(|top| (Path::new(name).join(top), top.into())).collect()
    }
}

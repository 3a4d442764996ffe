//! Documents are opened from real files, and what was opened can be written down again.

use std::{
    cell::RefCell,
    path::{Path, PathBuf},
    sync::Arc,
};

use lumivox_core::{
    CancelToken, Lasso, Preset, Progress, Scene, VolumeInstance,
    document::{
        Display, Entry, Film, Keep, Labels, Look, Scan, SceneDocument, Style, TakenOff, View, Written,
    },
};
use lumivox_phantom::{SeriesDescription, write_dicom_series};
use lumivox_scene::{
    Audience, Note, OpenErrorKind, Opened, Opening, Part, Silent, content_of, cut_anew, open, save,
};

/// Hears everything.
#[derive(Default)]
struct Listener(RefCell<Vec<String>>);

impl Audience for Listener {
    fn note(&self, note: Note) {
        self.0.borrow_mut().push(note.text);
    }

    fn say(&self, line: &str) {
        self.0.borrow_mut().push(line.to_owned());
    }

    fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T {
        work(Progress::SILENT)
    }
}

/// A label map over the ball: 1 on one side of it, 2 on the other, 3 in the air of a corner.
fn labels(folder: &Path, name: &str, high: u8) {
    let mut file =
        b"NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 10 10 10\n".to_vec();
    file.extend(b"space directions: (2.4,0,0) (0,2.4,0) (0,0,2.4)\nspace origin: (-10.8,-10.8,-10.8)\nencoding: raw\n\n");
    file.extend((0..1000).map(|i| {
        if i == 0 {
            3
        } else if i % 10 >= 5 {
            high
        } else {
            1
        }
    }));
    std::fs::write(folder.join(name), file).unwrap();
}

/// A folder with a ball of bone as a CT in `scans/ball`.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let ball = lumivox_phantom::sphere(900.0, 9.0, 2.0);
    let (cancel, at) = (CancelToken::new(), folder.path().join("scans/ball"));
    write_dicom_series(&ball, &at, &SeriesDescription::default(), Progress::SILENT, &cancel).unwrap();
    folder
}

fn document() -> SceneDocument {
    let mut entry = Entry::new(Scan::of_files(vec!["scans/ball".into()]));
    entry.look = Look { density: Some(0.3), ..Look::of_preset(Preset::CtBone) };
    SceneDocument {
        volumes: vec![entry],
        camera: View { azimuth: Some(30.0), ..View::default() },
        film: Film { size: [30, 20], ..Film::default() },
        display: Display::default(),
        ..SceneDocument::default()
    }
}

fn opened(document: &SceneDocument, folder: &Path, audience: &impl Audience) -> Opened {
    open(document, folder, &Opening::default(), audience, &CancelToken::new()).unwrap()
}

#[test]
fn what_was_opened_is_written_down_and_opened_again() {
    let folder = folder();
    let first = opened(&document(), folder.path(), &Silent);
    assert_eq!(first.scene.volumes[0].medium.density_scale, 0.3);
    let source = first.scene.volumes[0].volume.source().unwrap();
    assert!(source.keep == Keep::Patient && source.files[0].is_absolute(), "{source:?}");

    let camera = View::of(&first.camera);
    let written = SceneDocument { camera, ..SceneDocument::of(&first.scene).unwrap() };
    std::fs::create_dir(folder.path().join("scenes")).unwrap();
    let file: PathBuf = folder.path().join("scenes/ball.json");
    save(&written, &file).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(
        text.contains("\"../scans/ball\"") && !text.contains(&*folder.path().to_string_lossy()),
        "{text}"
    );
    let read = Written::parse(&file, text).unwrap();
    let again = opened(&read.document, read.folder(), &Silent);
    let (a, b) = (&first.scene.volumes[0], &again.scene.volumes[0]);
    assert_eq!((&a.medium, a.clip_box, a.layers), (&b.medium, b.clip_box, b.layers));
    assert_eq!(a.volume.voxels(), b.volume.voxels());
    assert!(a.world_from_patient.abs_diff_eq(b.world_from_patient, 1e-15));
    assert!(first.camera.world_from_camera.abs_diff_eq(again.camera.world_from_camera, 1e-15));
    assert_eq!(std::fs::read_dir(folder.path().join("scenes")).unwrap().count(), 1, "nothing half is left");
}

/// What lassos cut away of the ball, as a share of its voxels; whether that is seen is the labels' business.
fn cut_share(opened: &Opened) -> f64 {
    let labels = &opened.scene.volumes[0].labels.as_ref().unwrap().labels;
    let value = labels.cut_away().unwrap().value;
    labels.counts()[usize::from(value)] as f64 / labels.volume().voxel_count() as f64
}

#[test]
fn lassos_cut_spare_and_are_written_down() {
    let folder = folder();
    let mut document = document();
    // Whatever lies on one side of the middle.
    let far = 1e3;
    let half = vec![[0.0, -far], [far, -far], [far, far], [0.0, far]];
    let lasso = Lasso::new(Default::default(), true, half);
    document.volumes[0].lassos = vec![lasso.clone()];
    let first = opened(&document, folder.path(), &Silent);
    assert!((cut_share(&first) - 0.5).abs() < 0.1, "{}", cut_share(&first));
    let volume = &first.scene.volumes[0];
    let labelling = volume.labels.as_ref().unwrap();
    let value = labelling.labels.cut_away().unwrap().value;
    assert!(!labelling.style(value).visible && labelling.style(0).visible);
    let written = SceneDocument::of(&first.scene).unwrap();
    assert_eq!(written.volumes[0].lassos, std::slice::from_ref(&lasso));
    assert!(written.volumes[0].labels.is_none(), "they are nobody's labels");

    // With labels those come back, too; the ones that cuts spare are whole, and a style for all does not bring back what is cut.
    labels(folder.path(), "labels.nrrd", 2);
    let style = |label: &str| Style { label: label.into(), ..Style::default() };
    document.volumes[0].labels = Some(Labels {
        files: vec!["labels.nrrd".into()],
        styles: vec![
            Style { clipped: Some(false), ..style("2") },
            Style { visible: Some(true), ..style("*") },
        ],
        ..Labels::default()
    });
    let spared = opened(&document, folder.path(), &Silent);
    assert!(cut_share(&spared) < cut_share(&first) - 0.1, "{}", cut_share(&spared));
    let labelling = spared.scene.volumes[0].labels.as_ref().unwrap();
    assert!(!labelling.style(labelling.labels.cut_away().unwrap().value).visible);
    let written = SceneDocument::of(&spared.scene).unwrap();
    let entry = &written.volumes[0];
    assert_eq!(entry.lassos, [lasso]);
    let own = entry.labels.as_ref().unwrap();
    assert!(own.files[0].ends_with("labels.nrrd"), "{own:?}");
    let named: Vec<&str> = own.styles.iter().map(|style| style.label.as_str()).collect();
    assert!(!named.contains(&"cut away") && named.len() > 2, "{named:?}");
    let again = opened(&written, folder.path(), &Silent);
    assert_eq!(again.scene.volumes[0].labels.as_ref().unwrap().labels, labelling.labels);

    // Cut anew, they are the same as opened so.
    let parts = |opened: &Opened| {
        let part = |it: &VolumeInstance| Part {
            volume: it.volume.clone(),
            labels: it.labels.as_ref().map(|labelling| labelling.labels.clone()),
            peel: None,
        };
        opened.scene.volumes.iter().map(part).collect::<Vec<_>>()
    };
    let cut = |document: &SceneDocument, opened: &Opened| {
        cut_anew(document, parts(opened), None, &Silent, &CancelToken::new()).unwrap()
    };
    let mut inverted = document.clone();
    inverted.volumes[0].lassos[0].inverted = true;
    let of = |scene: &Scene| scene.volumes[0].labels.as_ref().unwrap().labels.clone();
    assert_eq!(of(&cut(&inverted, &spared)), of(&opened(&inverted, folder.path(), &Silent).scene));
    let mut uncut = document.clone();
    uncut.volumes[0].lassos.clear();
    let labels = of(&cut(&uncut, &spared));
    assert!(labels.cut_away().is_none() && labels.dims() == [10; 3], "the map as it lies in its file");
    assert_eq!(labels, of(&opened(&uncut, folder.path(), &Silent).scene));
}

#[test]
fn another_scan_in_its_place_is_told() {
    let folder = folder();
    let mut document = document();
    let scan = &mut document.volumes[0].scan;
    scan.keep = Keep::Everything;
    let content = content_of(&opened(&document, folder.path(), &Silent).scene.volumes[0].volume);
    assert_eq!(content.len(), "sha256:".len() + 64);
    let told = |content: String| {
        let mut document = document.clone();
        document.volumes[0].scan.content = Some(content);
        let listener = Listener::default();
        opened(&document, folder.path(), &listener);
        listener.0.into_inner().iter().any(|note| note.contains("not the scan that the scene was saved with"))
    };
    assert!(!told(content.clone()) && told(content.replace(|c: char| c.is_ascii_digit(), "0")));
}

/// One scan that stands in a scene many times is read once for each way of reading it, and its patient found once for each thing
/// that is shown of it.
#[test]
fn a_scan_is_read_once_however_often_it_is_there() {
    let folder = folder();
    let mut document = document();
    let first = document.volumes[0].clone();
    let at = |x: f64| Some([[1.0, 0.0, 0.0, x], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0]]);
    document.volumes =
        (0..6).map(|i| Entry { world_from_patient: at(f64::from(i)), ..first.clone() }).collect();
    // Another look of the same; all of it; and values that are read otherwise.
    document.volumes[2].look.density = Some(0.7);
    document.volumes[3].scan.keep = Keep::Everything;
    document.volumes[4].scan.slope = Some(2.0);
    document.volumes[5].labels = Some(Labels::default());
    let listener = Counter::default();
    let opened = opened(&document, folder.path(), &listener);
    let volumes: Vec<_> = opened.scene.volumes.iter().map(|instance| &instance.volume).collect();
    let is_same = |a: usize, b: usize| Arc::ptr_eq(volumes[a], volumes[b]);
    assert!(is_same(0, 1) && is_same(0, 2) && !is_same(0, 3) && !is_same(0, 4) && !is_same(0, 5));
    assert_eq!(volumes[3].source().unwrap().keep, Keep::Everything);
    assert_eq!(volumes[0].source().unwrap().keep, Keep::Patient);
    assert_eq!(volumes[0].dims(), volumes[3].dims());
    assert_eq!(
        volumes[4].value_range()[1],
        2.0 * volumes[0].value_range()[1] - 2.0 * volumes[0].intercept() + volumes[0].intercept()
    );
    let labels: Vec<bool> = opened.scene.volumes.iter().map(|instance| instance.labels.is_some()).collect();
    assert_eq!(labels, [false, false, false, false, false, true]);
    assert_eq!(opened.scene.volumes[2].medium.density_scale, 0.7);
    // What is said of a look is said once for all that look so.
    document.volumes.iter_mut().for_each(|entry| entry.look = Look::default());
    let heard = Heard::default();
    self::opened(&document, folder.path(), &heard);
    let presets = heard.0.into_inner().iter().filter(|line| line.trim_start().starts_with("preset ")).count();
    assert_eq!(
        presets, 4,
        "of six entries: three that share all, one of everything, one of another slope, one with labels"
    );
    // Read twice, the patient found in three: that of the first three, of the other slope, and with labels.
    let stages = listener.0.into_inner();
    assert_eq!(stages, 5, "so often somebody had to wait");
}

/// Whether it is another scan is told once for all that say the same of it, and to those alone.
#[test]
fn another_scan_is_told_once() {
    let folder = folder();
    let mut document = document();
    document.volumes[0].scan.keep = Keep::Everything;
    let right = content_of(&opened(&document, folder.path(), &Silent).scene.volumes[0].volume);
    let one = document.volumes[0].clone();
    let of = |content: Option<&str>| {
        let scan = Scan { content: content.map(ToOwned::to_owned), ..one.scan.clone() };
        Entry { scan, ..one.clone() }
    };
    let (wrong, other) = ("sha256:00", "sha256:11");
    document.volumes = vec![of(None), of(Some(&right)), of(Some(wrong)), of(Some(wrong)), of(Some(other))];
    let listener = Listener::default();
    opened(&document, folder.path(), &listener);
    let told = listener.0.into_inner().iter().filter(|note| note.contains("not the scan")).count();
    assert_eq!(told, 2);
}

/// Hears what is done.
#[derive(Default)]
struct Heard(RefCell<Vec<String>>);

impl Audience for Heard {
    fn note(&self, _: Note) {}

    fn say(&self, line: &str) {
        self.0.borrow_mut().push(line.to_owned());
    }

    fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T {
        work(Progress::SILENT)
    }
}

/// Counts what is waited for.
#[derive(Default)]
struct Counter(RefCell<usize>);

impl Audience for Counter {
    fn note(&self, _: Note) {}

    fn say(&self, _: &str) {}

    fn watch<T>(&self, work: impl FnOnce(Progress<'_>) -> T) -> T {
        *self.0.borrow_mut() += 1;
        work(Progress::SILENT)
    }
}

#[test]
fn label_files_are_loaded_once_and_others_in_their_place_are_told() {
    let folder = folder();
    labels(folder.path(), "halves.nrrd", 2);
    let mut document = document();
    let mut of = Labels { files: vec!["halves.nrrd".into()], ..Labels::default() };
    of.styles = vec![Style { label: "#3".into(), visible: Some(true), ..Style::default() }];
    document.volumes[0].labels = Some(of);
    let second = document.volumes[0].clone();
    document.volumes.push(second);
    let told = |document: &SceneDocument| {
        let listener = Listener::default();
        let opened = opened(document, folder.path(), &listener);
        let maps: Vec<_> =
            opened.scene.volumes.iter().map(|v| v.labels.as_ref().unwrap().labels.clone()).collect();
        assert!(Arc::ptr_eq(&maps[0], &maps[1]), "one map for both");
        (content_of(maps[0].volume()), listener.0.into_inner())
    };
    let (content, notes) = told(&document);
    let is_unseen = |note: &&String| note.starts_with("hardly anything is seen of label 3");
    assert_eq!(notes.iter().filter(is_unseen).count(), 2, "air, in each scan: {notes:?}");
    let is_other = |note: &String| note.contains("not the labels that the scene was saved with");
    document.volumes.iter_mut().for_each(|e| e.labels.as_mut().unwrap().content = Some(content.clone()));
    assert!(!told(&document).1.iter().any(is_other));
    labels(folder.path(), "halves.nrrd", 1);
    assert!(told(&document).1.iter().any(is_other));
}

#[test]
fn what_cannot_be_opened_is_told_by_its_place() {
    let folder = folder();
    let fails = |change: &dyn Fn(&mut SceneDocument)| {
        let mut document = document();
        change(&mut document);
        let error =
            open(&document, folder.path(), &Opening::default(), &Silent, &CancelToken::new()).unwrap_err();
        (error.volume, error.keys, error.to_string())
    };
    let (volume, keys, why) = fails(&|document| document.volumes[0].scan.files[0] = "scans/bowl".into());
    assert!((volume, keys) == (Some(0), &["scan", "files"]) && why.contains("bowl"), "{why}");
    let (_, keys, why) = fails(&|document| document.volumes[0].scan.axes = Some("XYZ".into()));
    assert!(keys == ["scan"] && why.starts_with("axes: "), "{why}");
    let styles = vec![Style { label: "spleen".into(), ..Style::default() }];
    let (_, keys, why) = fails(&|document| {
        document.volumes[0].labels = Some(Labels { styles: styles.clone(), ..Labels::default() })
    });
    assert!(keys == ["labels", "styles"] && why.contains("there is no such label"), "{why}");
    let (volume, keys, _) = fails(&|document| document.environment.source = "sky.hdr".into());
    assert_eq!((volume, keys), (None, &["environment", "source"][..]));
    let at = [10.0, 0.0, 0.0];
    let (_, keys, _) = fails(&|document| {
        document.camera = View { eye: Some(at), target: Some(at), ..View::default() };
    });
    assert_eq!(keys, ["camera"]);

    let cancelled = CancelToken::new();
    cancelled.cancel();
    let error = open(&document(), folder.path(), &Opening::default(), &Silent, &cancelled).unwrap_err();
    assert!(!matches!(error.kind, OpenErrorKind::Wrong(_)), "{error}");
}

#[test]
fn what_is_taken_off_is_what_was_said_else_what_the_look_hides_behind() {
    let folder = folder();
    let voxels = |taken_off: Option<TakenOff>| {
        let mut document = document();
        document.volumes[0].scan.taken_off = taken_off;
        let shown = opened(&document, folder.path(), &Silent);
        let volume = shown.scene.volumes[0].volume.clone();
        (volume.source().unwrap().taken_off, volume.voxels().clone())
    };
    let (said, whole) = voxels(Some(TakenOff::Nothing));
    assert_eq!(said, Some(TakenOff::Nothing));
    // A ball of bone is no body: nothing is sure enough to be taken off, whatever was asked for.
    let (said, asked) = voxels(Some(TakenOff::Depth(4.0)));
    assert_eq!((said, asked == whole), (Some(TakenOff::Nothing), true));
}

//! What the interface shows, as plain data, and what it was asked to do.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui::{Rect, TextureHandle};
use lumivox_core::document::{self, Measurement, MeasurementKind, SceneDocument};
use lumivox_core::glam::{DMat3, DQuat, DVec2, DVec3};
use lumivox_core::{Labelling, Orbit, Preset};
use lumivox_import::SeriesSummary;
use lumivox_viewport::PictureProgress;

use crate::archive::Request;
use crate::darkroom::{ExportDraft, looks_for};
use crate::jobs::Busy;
use crate::measuring::{Draft, Said};
use crate::opening::SharedStudy;
use crate::overlay::{Overlay, Sizes};
use crate::panels::lasso::Drawing;
use crate::panels::names::Named;
use crate::session::Session;
use crate::settings::Settings;
use crate::slices::{
    Axes, Geometry, Plane, Projection, Slab, Window, bounds_mm, reach_mm, step_mm, window_for,
};
use crate::words::Word;

/// One of the views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ViewId {
    /// Path-traced.
    ThreeD,
    /// A slice.
    Slice(Plane),
}

impl ViewId {
    /// All of them, in the order of their keys.
    pub const ALL: [Self; 5] = [
        Self::ThreeD,
        Self::Slice(Plane::Axial),
        Self::Slice(Plane::Coronal),
        Self::Slice(Plane::Sagittal),
        Self::Slice(Plane::Oblique),
    ];

    /// What it is called.
    pub fn word(self) -> Word {
        match self {
            Self::ThreeD => Word::ThreeD,
            Self::Slice(Plane::Axial) => Word::Axial,
            Self::Slice(Plane::Coronal) => Word::Coronal,
            Self::Slice(Plane::Sagittal) => Word::Sagittal,
            Self::Slice(Plane::Oblique) => Word::Oblique,
        }
    }
}

/// How views share the room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// A large 3D, and slices beside it.
    Main,
    /// Two by two.
    Grid,
    /// The active one alone.
    One,
}

/// What the left button does in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tool {
    /// Turns, changes the window, places the cross: as the mouse's profile says.
    #[default]
    Navigate,
    /// Places points of a measurement.
    Measure(MeasurementKind),
    /// Moves and widens the look, in the 3D view.
    Shape,
    /// Cuts away what a line is drawn around.
    Lasso,
}

impl Tool {
    /// All of them, in the order of their buttons.
    pub const ALL: [Self; 6] = [
        Self::Navigate,
        Self::Measure(MeasurementKind::Distance),
        Self::Measure(MeasurementKind::Angle),
        Self::Measure(MeasurementKind::Region),
        Self::Shape,
        Self::Lasso,
    ];
}

/// What the panel at the right is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tab {
    /// Looks, curve and light.
    #[default]
    Look,
    /// What is cut away.
    Cut,
    /// What the scan is made of.
    Structures,
    /// What was measured.
    Measure,
}

impl Tab {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Look, Self::Cut, Self::Structures, Self::Measure];
}

/// A point of the curve of opacity and colour, by its place in its list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CurvePoint {
    /// Of opacity.
    Opacity(usize),
    /// Of colour.
    Color(usize),
}

/// What is asked for by a file dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Files to open.
    Files,
    /// A folder to open.
    Folder,
    /// Where a scene is saved; a name for it.
    SaveScene(String),
    /// Where a picture is saved; a name for it.
    SavePicture(String),
    /// Where the pictures of a turn are saved; a name for them, and how many they are.
    SaveTurn(String, u32),
    /// Where a page is saved; a name for it, and how many voxels a side of its scan has at most.
    SavePage(String, usize),
    /// Where measurements are saved; a name for them.
    SaveTable(String),
    /// A panorama of light.
    Light,
    /// Files of one label map.
    Labels,
    /// A folder with a mask for each structure, or a DICOM segmentation.
    LabelFolder,
}

/// What a person wants done, by a click, a key or a drop.
#[derive(Clone, Debug)]
pub enum Action {
    /// A file dialog.
    Ask(Ask),
    /// These files and folders.
    Open(Vec<PathBuf>),
    /// Another series of the study.
    Series(usize),
    /// Another look.
    Look(Preset),
    /// The camera goes there.
    Camera(Orbit),
    /// All that is seen, from these angles in degrees.
    Frame(f64, f64),
    /// A change of the document that a panel made.
    Change(Word, Box<SceneDocument>),
    /// The point that all views share.
    Cross(DVec3),
    /// A command back.
    Undo,
    /// And forward.
    Redo,
    /// The dialog about the program.
    About,
    /// The dialog of archives.
    ArchiveDialog,
    /// A series of an archive is fetched and opened.
    Fetch(Box<Request>),
    /// The dialog of pictures for files.
    ExportDialog,
    /// The dialog of pages for others.
    ShareDialog,
    /// It was read that this is no medical device.
    Agree,
    /// Settings were changed.
    Settings(Settings),
    /// Whatever runs is to end.
    Cancel,
    /// The view that keys are for, to the clipboard.
    Copy,
    /// Unsaved work of another run is opened, or thrown away.
    Restore(bool),
    /// A turn in so many pictures of that name, whatever is there.
    Turn(PathBuf, u32),
    /// The window is closed, whatever is unsaved.
    Close,
    /// The scene is saved, and then the window closed.
    SaveAndClose,
}

/// Series that could be opened.
#[derive(Default)]
pub struct Strip {
    /// All of them, the best first.
    pub series: Vec<SeriesSummary>,
    /// Which is shown.
    pub chosen: usize,
    /// What they are loaded from.
    pub study: Option<SharedStudy>,
    /// Their pictures, as far as they are there.
    pub thumbnails: HashMap<usize, TextureHandle>,
}

/// A slice on the screen.
#[derive(Default)]
pub struct SliceView {
    /// How many times as large as where all fits.
    pub zoom: f64,
    /// By how much its content was moved, in mm.
    pub moved: DVec2,
    /// Its picture, and what that shows.
    pub drawn: Option<(Drawn, TextureHandle)>,
}

/// What a slice's picture shows.
#[derive(Clone)]
pub struct Drawn {
    /// Where.
    pub geometry: Geometry,
    /// From black to white.
    pub window: Window,
    /// How thick.
    pub slab: Slab,
    /// Structures over it.
    pub overlay: Option<Arc<Overlay>>,
}

impl PartialEq for Drawn {
    fn eq(&self, other: &Self) -> bool {
        let overlay = match (&self.overlay, &other.overlay) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            (own, other) => own.is_none() && other.is_none(),
        };
        (self.geometry, self.window, self.slab) == (other.geometry, other.window, other.slab) && overlay
    }
}

/// What lies under the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Where, in the patient's mm (LPS).
    pub patient_mm: DVec3,
    /// The scan's value there.
    pub value: f64,
}

/// A dialog over everything.
#[derive(Clone, Debug, PartialEq)]
pub enum Dialog {
    /// What the program is, and its keys.
    About,
    /// What an archive has.
    Archive,
    /// A picture for a file.
    Export(ExportDraft),
    /// A page for others: voxels a side of its scan at most, and whether it may be given to them.
    Share(usize, bool),
    /// Another run left unsaved work: this file.
    Restore(PathBuf),
    /// The pictures of a turn would replace files.
    Overwrite {
        /// The name that they were given.
        file: PathBuf,
        /// How many they are.
        steps: u32,
        /// Files that are there.
        there: String,
    },
    /// The window is to be closed, and something is unsaved; or another scan `opens` in its place.
    Leave {
        /// Whether that is what is to come.
        opens: bool,
    },
}

/// All that is shown.
pub struct State {
    /// What a person chose.
    pub settings: Settings,
    /// The scan, where one is open.
    pub session: Option<Session>,
    /// Series.
    pub strip: Strip,
    /// Slices, in the order of [`Plane::ALL`].
    pub slices: [SliceView; 4],
    /// How the oblique plane is turned in the patient.
    pub oblique: DQuat,
    /// Whether it is among the views.
    pub shows_oblique: bool,
    /// How thick slices are.
    pub slab: Slab,
    /// What the left button does.
    pub tool: Tool,
    /// What the panel at the right is about.
    pub tab: Tab,
    /// A measurement that is being made.
    pub draft: Option<Draft>,
    /// A line that is being drawn.
    pub lasso: Option<Drawing>,
    /// What measurements say, as far as that was asked.
    pub said: RefCell<Said>,
    /// How large structures are.
    pub sizes: Option<Sizes>,
    /// The chosen point of the curve.
    pub curve_point: Option<CurvePoint>,
    /// The values that the curve is drawn over.
    pub curve_range: [f64; 2],
    /// Structures over slices, and the labels that they are of.
    pub overlay: Option<(Labelling, Arc<Overlay>)>,
    /// Names beside the 3D picture.
    pub named: Named,
    /// The point that all views share, in the patient's mm.
    pub cross: DVec3,
    /// What is black and white in slices.
    pub window: Window,
    /// How views share the room.
    pub layout: Layout,
    /// The one before a view was shown alone.
    pub layout_before: Layout,
    /// The one that keys are for.
    pub active: ViewId,
    /// Where it is in the window.
    pub active_rect: Rect,
    /// Looks that may suit this scan, the best first.
    pub looks: Vec<Preset>,
    /// The scan in them, as far as that is there.
    pub tiles: HashMap<Preset, TextureHandle>,
    /// Whether there are any, or names alone.
    pub has_tiles: bool,
    /// What is under the pointer.
    pub probe: Option<Probe>,
    /// How far the 3D picture is.
    pub progress: PictureProgress,
    /// Pixels of the 3D view.
    pub view_size: [u32; 2],
    /// What is done beside the interface.
    pub busy: Option<(Word, Busy)>,
    /// What went wrong.
    pub failed: Option<(Word, String)>,
    /// What was done.
    pub done: Option<String>,
    /// A dialog.
    pub dialog: Option<Dialog>,
    /// Whether all that was told of the scan is shown.
    pub shows_all_notes: bool,
    /// What was asked for in this frame.
    pub actions: Vec<Action>,
}

impl State {
    /// Nothing is open.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            session: None,
            strip: Strip::default(),
            slices: Default::default(),
            oblique: DQuat::IDENTITY,
            shows_oblique: false,
            slab: Slab::default(),
            tool: Tool::Navigate,
            tab: Tab::Look,
            draft: None,
            lasso: None,
            said: RefCell::default(),
            sizes: None,
            curve_point: None,
            curve_range: [0.0; 2],
            overlay: None,
            named: Named::default(),
            cross: DVec3::ZERO,
            window: [0.0, 1.0],
            layout: Layout::Main,
            layout_before: Layout::Main,
            active: ViewId::ThreeD,
            active_rect: Rect::NOTHING,
            looks: vec![],
            tiles: HashMap::new(),
            has_tiles: true,
            probe: None,
            progress: PictureProgress::default(),
            view_size: [1, 1],
            busy: None,
            failed: None,
            done: None,
            dialog: None,
            shows_all_notes: false,
            actions: vec![],
        }
    }

    /// A word in the language that was chosen.
    pub fn say(&self, word: Word) -> &'static str {
        word.of(self.settings.language)
    }

    /// What a measurement of the scan says, in lines; the first is enough for a list.
    pub fn lines(&self, measurement: &Measurement) -> Vec<String> {
        self.session.as_ref().map_or(vec![], |session| {
            self.said.borrow_mut().lines(measurement, session.scan(), self.settings.language)
        })
    }

    /// Asks for something.
    pub fn act(&mut self, action: Action) {
        self.actions.push(action);
    }

    /// Changes a copy of the document by a command of that name.
    pub fn change(&mut self, what: Word, change: impl FnOnce(&mut SceneDocument)) {
        if let Some(session) = &self.session {
            let mut document = session.document().clone();
            change(&mut document);
            self.act(Action::Change(what, Box::new(document)));
        }
    }

    /// Shows a scan: views begin anew.
    pub fn begin(&mut self, session: Session) {
        let scan = session.scan();
        let [low, high] = bounds_mm(scan);
        self.cross = 0.5 * (low + high);
        self.window = window_for(scan);
        self.looks = looks_for(scan);
        self.slices = std::array::from_fn(|_| SliceView { zoom: 1.0, ..SliceView::default() });
        self.oblique = DQuat::from_rotation_z(30_f64.to_radians());
        (self.slab, self.tool, self.draft, self.said, self.overlay) = Default::default();
        self.lasso = None;
        self.named = Named::default();
        (self.curve_point, self.curve_range, self.sizes) = Default::default();
        self.tiles.clear();
        (self.probe, self.failed, self.done) = (None, None, None);
        self.shows_all_notes = false;
        if let Some(slices) = session.document().slices {
            self.see(&slices);
        }
        self.session = Some(session);
    }

    /// How slices are seen, as documents say it: of odd values what is in the range of those.
    pub fn slices(&self) -> document::Slices {
        let thickness = self.slab.thickness_mm;
        let shows = match self.slab.projection {
            Projection::Thin => None,
            Projection::Maximum => Some(document::Seen::Maximum),
            Projection::Mean => Some(document::Seen::Mean),
            Projection::Minimum => Some(document::Seen::Minimum),
        };
        let [right, down, _] = self.axes(Plane::Oblique).map(|axis| axis.to_array());
        document::Slices {
            cross: self.cross.to_array(),
            window: self.window,
            slab: shows.map(|shows| document::Slab { shows, thickness }),
            oblique: self.shows_oblique.then_some([right, down]),
        }
        .clamped()
    }

    /// Slices are seen as a document says.
    fn see(&mut self, slices: &document::Slices) {
        self.cross = DVec3::from_array(slices.cross);
        self.window = slices.window;
        if let Some(slab) = slices.slab {
            let projection = match slab.shows {
                document::Seen::Maximum => Projection::Maximum,
                document::Seen::Mean => Projection::Mean,
                document::Seen::Minimum => Projection::Minimum,
            };
            self.slab = Slab { projection, thickness_mm: slab.thickness };
        }
        self.shows_oblique = slices.oblique.is_some();
        if let Some([right, down]) = slices.oblique.map(|axes| axes.map(DVec3::from_array)) {
            let right = right.normalize_or(DVec3::X);
            let normal = right.cross(down).normalize_or(DVec3::Y);
            let [x, y, z] = Plane::Oblique.axes();
            let own = DMat3::from_cols(right, normal.cross(right), normal);
            let turn = own * DMat3::from_cols(x, y, z).transpose();
            self.oblique = DQuat::from_mat3(&turn).normalize();
        }
    }

    /// Shows a view alone, or all again.
    pub fn toggle_one(&mut self, view: ViewId) {
        self.active = view;
        if self.layout == Layout::One {
            self.layout = self.layout_before;
        } else {
            self.layout_before = self.layout;
            self.layout = Layout::One;
        }
    }

    /// Where a plane's axes lie in the patient.
    pub fn axes(&self, plane: Plane) -> Axes {
        match plane {
            // A turn of many turns is one still.
            Plane::Oblique => plane.axes().map(|axis| DMat3::from_quat(self.oblique.normalize()) * axis),
            _ => plane.axes(),
        }
    }

    /// Moves the shared point by so many slices of a plane.
    pub fn step(&mut self, plane: Plane, slices: f64) {
        let [_, _, normal] = self.axes(plane);
        self.move_along(normal, slices);
    }

    fn move_along(&mut self, axis: DVec3, voxels: f64) {
        let Some(session) = &self.session else { return };
        let [low, high] = reach_mm(session.scan(), axis);
        let at = self.cross.dot(axis);
        self.cross += axis * ((at + step_mm(session.scan(), axis) * voxels).clamp(low, high) - at);
    }

    /// Moves the cross so many voxels to the right and down in a slice.
    pub fn move_cross(&mut self, plane: Plane, by: [f64; 2]) {
        let [right, down, _] = self.axes(plane);
        self.move_along(right, by[0]);
        self.move_along(down, by[1]);
    }

    /// Takes another tool; what was being made is left.
    pub fn take(&mut self, tool: Tool) {
        (self.tool, self.draft, self.lasso) = (tool, None, None);
        match tool {
            Tool::Measure(_) => self.tab = Tab::Measure,
            Tool::Shape => self.tab = Tab::Look,
            Tool::Lasso => self.tab = Tab::Cut,
            Tool::Navigate => {}
        }
    }

    /// Structures over slices, as the scene has them.
    pub fn follow_labels(&mut self) {
        let labelling =
            self.session.as_ref().and_then(|session| session.scene().0.volumes.first()?.labels.clone());
        let is_known = match (&self.overlay, &labelling) {
            (Some((known, _)), Some(labelling)) => known.is_same(labelling),
            (known, labelling) => known.is_none() && labelling.is_none(),
        };
        if !is_known {
            self.overlay = labelling.map(|labelling| {
                let known = self.sizes.take().filter(|sizes| sizes.are_of(&labelling.labels));
                let sizes = known.unwrap_or_else(|| Sizes::of(&labelling.labels));
                let overlay = Arc::new(Overlay::new(&labelling, &sizes));
                self.sizes = Some(sizes);
                (labelling, overlay)
            });
        }
    }
}

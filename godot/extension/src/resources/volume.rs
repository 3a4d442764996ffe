//! A scan as a Godot resource.

use std::sync::{Arc, OnceLock};

use godot::classes::image::Format;
use godot::classes::{IResource, Image, Resource};
use godot::prelude::*;
use lumivox_core::{CancelToken, Histogram, Medium, Preset, Progress, Volume};
use lumivox_import::ImportReport;
use lumivox_segmentation::Surroundings;

use super::derived::{Derived, Part, Parts};
use super::phantom;
use super::{Options, stored};
use crate::load_options::{LoadOptions, Loaded};
use crate::{codecs, convert, kept_paths};

/// A CT or MR scan: voxels in physical units (Hounsfield units for CT) at their true size and place in the patient.
///
/// Drop a DICOM folder or a NIfTI, NRRD or MetaImage file on the FileSystem dock, call [method load_file], or use
/// [LumivoxImporter] to load one without holding up the game. Give it to a [LumivoxVolume3D] to see it. Save it as a
/// binary resource ([code].res[/code]): text would be many times larger.
///
/// Of a folder of DICOM files in the project, the first one is the scan. To [code]load[/code] another gives a volume
/// that holds nothing ([method is_empty]) but, as the metadata [code]lumivox_series[/code], the path of the first.
#[derive(GodotClass)]
#[class(tool, init, base = Resource)]
pub struct LumivoxVolume {
    #[var(rename = _stored, get = _get_stored, set = _set_stored, usage_flags = [STORAGE])]
    stored: PhantomVar<VarDictionary>,
    volume: Option<Arc<Volume>>,
    /// What was taken out of it: the table, clothes, cables.
    surroundings: Option<Arc<Surroundings>>,
    report: VarDictionary,
    histogram: OnceLock<Histogram>,
    default_medium: OnceLock<Medium>,
    /// Its depths below the skin, once they were asked for and computed; none where no skin was found.
    depth: OnceLock<Derived>,
    parts: Parts,
    base: Base<Resource>,
}

#[godot_api]
impl LumivoxVolume {
    /// A scan that is computed, of a kind that the command [code]lumivox phantom[/code] knows: [code]"head"[/code] is an
    /// anatomical CT of a head, [code]"torso"[/code] one of a torso, [code]"torso-pet"[/code] a PET of that,
    /// [code]"mr-head"[/code] and [code]"mr-brain"[/code] are MRs, [code]"cube"[/code] is a test body whose values rise from its
    /// corners to its centre, [code]"slab"[/code] and [code]"sphere"[/code] are homogeneous. [param size] is the number of voxels
    /// along the longest side, 8 to 1024; 0 stands for 128. [param options] may hold [code]seed[/code], and of a torso
    /// [code]table[/code], [code]blanket[/code], [code]breasts[/code], [code]padding[/code] (whether there are),
    /// [code]arms[/code] ([code]"raised"[/code] or [code]"sides"[/code]), [code]metal[/code] ([code]"sternal-wires"[/code],
    /// [code]"pacemaker"[/code] or [code]"rod"[/code]), [code]field_of_view[/code] (mm), [code]shift[/code] (a [Vector3] of mm in
    /// the patient) and [code]tilt[/code] (degrees). [code]null[/code] and an error in the output for anything else. A large one
    /// takes seconds: compute it on another thread.
    #[func]
    pub fn phantom(
        kind: GString,
        #[opt(default = 0)] size: i64,
        #[opt(default = &Options::none())] options: Options,
    ) -> Option<Gd<Self>> {
        match phantom::compute(&kind.to_string(), size, &options.0) {
            Ok(volume) => Some(Self::of(volume, VarDictionary::new())),
            Err(why) => {
                godot_error!("{why}");
                None
            }
        }
    }

    /// Loads a scan and waits for it: a file of any format (DICOM, NIfTI, NRRD, MetaImage, RAW), a folder of DICOM
    /// files, or a zip archive of one. [param options] may hold [code]series[/code] (which series of a DICOM study: its
    /// position from 1, its SeriesInstanceUID or its number), [code]phase[/code] (which volume of a series with
    /// several, counted from 1), [code]raw[/code] (what a RAW file holds, such as
    /// [code]256x256x108:i16le:spacing=1,1,2[/code]), [code]spacing[/code], [code]axes[/code] and [code]layout[/code] (of
    /// arrays, stacks of pictures and OME-Zarr: mm between voxels, such as [code]0.5,0.5,2[/code]; where x, y and z grow to,
    /// such as [code]LPS[/code]; an array's axes, such as [code]zyx[/code]),
    /// [code]slope[/code], [code]intercept[/code], [code]modality[/code]
    /// ([code]CT[/code], [code]MR[/code], [code]PET[/code], [code]other[/code]) and [code]unit[/code] (what its values mean, in
    /// place of what the file says), [code]allow_outside_data[/code] (whether a header such as
    /// [code].mhd[/code] may name data files anywhere, not only beside it or below) and [code]keep_everything[/code]
    /// (whether what lies around the patient in a CT is a part of the scan: the table, clothes, cables; by default it is
    /// looked for and put aside, where it can be told from the patient for sure, and the notes of [method get_report]
    /// say so: [member LumivoxVolume3D.keep_everything] shows it). Returns
    /// [code]null[/code] and says why in the output if it cannot be loaded.
    #[func]
    pub fn load_file(path: GString, #[opt(default = &Options::none())] options: Options) -> Option<Gd<Self>> {
        let loaded = LoadOptions::parse(&options.0).and_then(|options| {
            let paths = [convert::system_path(&path)];
            let (silent, never) = (Progress::SILENT, CancelToken::new());
            codecs::name_worker();
            lumivox_import::load(&paths, &options.import, silent, &never)
                .and_then(|imported| Ok(options.keep(imported, silent, &never)?))
                .map_err(|error| error.to_string())
        });
        match loaded {
            Ok(loaded) => Some(Self::loaded(loaded)),
            Err(message) => {
                godot_error!("{message}");
                None
            }
        }
    }

    /// Voxels along the scan's own x, y and z axes; zeros without a scan.
    #[func]
    pub fn get_dimensions(&self) -> Vector3i {
        self.volume.as_ref().map_or(Vector3i::ZERO, |volume| dimensions(volume.dims()))
    }

    /// Distances between neighbouring voxels along the scan's own axes, in millimetres; zeros without a scan.
    #[func]
    pub fn get_spacing_mm(&self) -> Vector3 {
        self.volume.as_ref().map_or(Vector3::ZERO, |volume| convert::vector(volume.spacing_mm()))
    }

    /// Edge lengths along the scan's own axes, in metres: what it measures in a scene. Zeros without a scan.
    #[func]
    pub fn get_size_m(&self) -> Vector3 {
        self.volume.as_ref().map_or(Vector3::ZERO, |volume| convert::vector(volume.size_mm() * 1e-3))
    }

    /// The smallest value as x and the largest as y, in the scan's unit (see [method get_unit]); zeros without a scan.
    #[func]
    pub fn get_value_range(&self) -> Vector2 {
        self.volume.as_ref().map_or(Vector2::ZERO, |volume| {
            let [low, high] = volume.value_range();
            Vector2::new(low as f32, high as f32)
        })
    }

    /// The unit of the values: [code]HU[/code] for most CT, [code]mg/ml[/code] for a map of iodine, [code]SUV[/code] for
    /// most PET; empty where it is not known and without a scan.
    #[func]
    pub fn get_unit(&self) -> GString {
        self.volume.as_ref().map_or(GString::new(), |volume| GString::from(volume.unit()))
    }

    /// The number of voxels in each of [param bins] equal parts, 1 to 65536, of the values from [code]range.x[/code] to
    /// [code]range.y[/code], in the scan's unit. Values outside are not counted; all are 0 without a scan. The first
    /// call looks at every voxel, later ones are quick.
    #[func]
    pub fn get_histogram(&self, bins: i64, range: Vector2) -> PackedFloat32Array {
        let bins = bins.clamp(1, 1 << 16) as usize;
        let Some(volume) = &self.volume else { return PackedFloat32Array::from(vec![0.0; bins]) };
        let histogram = self.histogram.get_or_init(|| Histogram::new(volume));
        histogram.counts(bins, [f64::from(range.x), f64::from(range.y)]).into()
    }

    /// How the scan was loaded: [code]format[/code], [code]series[/code] (a list of what could have been loaded),
    /// [code]chosen[/code] (which of them it is), [code]notes[/code] (sentences) and [code]skipped[/code] (a list with
    /// [code]path[/code] and [code]reason[/code]). Empty for a phantom.
    ///
    /// A series has [code]id[/code], [code]name[/code] (such as [code]CT series 4[/code], which names neither files nor
    /// the patient), [code]number[/code] ([code]null[/code] without one), [code]description[/code],
    /// [code]files[/code], [code]modality[/code] (DICOM's code, such as [code]CT[/code]), [code]dimensions[/code]
    /// (a [Vector3i] of voxels), [code]spacing_mm[/code] (a [Vector3]), [code]orientation[/code] of its slices
    /// ([code]axial[/code]), [code]phases[/code] (volumes in it), [code]unit[/code] of its values, [code]bytes[/code]
    /// of memory that one phase takes, [code]reason[/code] (why another series comes first, such as
    /// [code]a localizer[/code]; empty for the first) and [code]notes[/code] (sentences).
    ///
    /// Of this, a saved scan keeps nothing that names files or the patient's study: [code]format[/code], [code]notes[/code] and,
    /// of [code]series[/code], the one that it is without its [code]id[/code].
    #[func]
    pub fn get_report(&self) -> VarDictionary {
        self.report.clone()
    }

    /// The files or the folder that the scan was loaded from, as [code]res://[/code] or [code]user://[/code] paths where they lie
    /// there; empty for a phantom, and in an exported game for what lay in its project. Scenes name them
    /// ([method Lumivox.save_scene]). A scan that is saved in the project keeps files of the project, and for others a word that
    /// [code]res://.lumivox[/code] explains: that folder stays on this machine. What a game saves keeps paths: see
    /// [method forget_source].
    #[func]
    pub fn get_source_files(&self) -> PackedStringArray {
        let source = self.volume.as_ref().and_then(|volume| volume.source());
        kept_paths::shown_paths(source.into_iter().flat_map(|source| &source.files))
    }

    /// Forgets what files the scan is of, before it is saved and given to others: files and folders are often called by the
    /// patient's name. A scene with it cannot be saved any more.
    #[func]
    pub fn forget_source(&mut self) {
        if let Some(volume) = self.volume.take() {
            let volume = Arc::new(Arc::unwrap_or_clone(volume).without_source());
            let (surroundings, report) = (self.surroundings.take(), self.report.clone());
            self.set_volume(Some(volume), surroundings, report);
        }
    }

    /// What the scan may be called: [code]CT series 4[/code]. It names neither files nor folders, which may be called by
    /// the patient's name. [code]Scan[/code] for a phantom and without a scan.
    #[func]
    pub fn get_scan_name(&self) -> GString {
        let name = || {
            let series = self.report.get("series")?.try_to::<VarArray>().ok()?;
            let chosen = usize::try_from(self.report.get("chosen")?.try_to::<i64>().ok()?).ok()?;
            let one = series.get(chosen)?.try_to::<VarDictionary>().ok()?;
            one.get("name")?.try_to::<GString>().ok().filter(|name| !name.is_empty())
        };
        name().unwrap_or("Scan".into())
    }

    /// A slice as a grey image: black at values of [code]window.x[/code] and below, white at [code]window.y[/code] and
    /// above, in the scan's unit. [param axis] is the scan's own axis across the slice: 0, 1 or 2 for x, y or z;
    /// [param index] counts voxels along it from 0. Slices across z have x to the right and y downwards, the others
    /// have z upwards. [code]null[/code] if there is no such slice.
    #[func]
    pub fn get_slice(&self, axis: i64, index: i64, window: Vector2) -> Option<Gd<Image>> {
        let volume = self.volume.as_ref()?;
        let dims = volume.dims();
        let axis = usize::try_from(axis).ok().filter(|&a| a < 3)?;
        let index = usize::try_from(index).ok().filter(|&i| i < dims[axis])?;
        let (across, down) = [(1, 2), (0, 2), (0, 1)][axis];
        let [low, high] = [f64::from(window.x), f64::from(window.y)];
        let mut pixels = Vec::with_capacity(dims[across] * dims[down]);
        for row in 0..dims[down] {
            let row = if down == 2 { dims[2] - 1 - row } else { row };
            for column in 0..dims[across] {
                let mut voxel = [index; 3];
                (voxel[across], voxel[down]) = (column, row);
                let value = volume.value(voxel);
                let grey = if high > low { (value - low) / (high - low) } else { f64::from(value > low) };
                pixels.push((grey.clamp(0.0, 1.0) * 255.0).round() as u8);
            }
        }
        let (width, height) = (dims[across] as i32, dims[down] as i32);
        Image::create_from_data(width, height, false, Format::L8, &PackedByteArray::from(pixels))
    }

    /// Whether there is no scan in it: a new volume, or a slice that only names the file of its scan.
    #[func]
    pub fn is_empty(&self) -> bool {
        self.volume.is_none()
    }

    /// Whether something that lies around the patient was put aside when the scan was imported:
    /// [member LumivoxVolume3D.keep_everything] shows it.
    #[func]
    pub fn has_surroundings(&self) -> bool {
        self.surroundings.is_some()
    }

    #[func]
    fn _get_stored(&self) -> VarDictionary {
        let Some(volume) = &self.volume else { return VarDictionary::new() };
        let mut stored = stored::to_dictionary(volume, &self.report);
        stored::put_source(&mut stored, volume, &self.report);
        if let Some(surroundings) = &self.surroundings {
            stored::put_surroundings(&mut stored, surroundings);
        }
        stored
    }

    #[func]
    fn _set_stored(&mut self, stored: VarDictionary) {
        if stored.is_empty() {
            self.set_volume(None, None, VarDictionary::new());
            return;
        }
        let read = stored::from_dictionary(&stored).and_then(|(volume, report)| {
            let surroundings = stored::surroundings(&stored, &volume)?;
            Ok((volume, surroundings, report))
        });
        match read {
            Ok((volume, surroundings, report)) => {
                self.set_volume(Some(Arc::new(volume)), surroundings.map(Arc::new), report);
            }
            Err(why) => {
                let path = self.base().get_path();
                godot_error!("The volume {path} cannot be used: {why}. Import the scan again.");
            }
        }
    }
}

#[godot_api]
impl IResource for LumivoxVolume {}

impl LumivoxVolume {
    /// A resource that holds a volume.
    pub fn of(volume: Volume, report: VarDictionary) -> Gd<Self> {
        Self::shared(Arc::new(volume), report, None)
    }

    /// A resource of a volume that others hold, too, with its depths below the skin where they are known.
    pub fn shared(volume: Arc<Volume>, report: VarDictionary, depth: Option<Arc<Volume>>) -> Gd<Self> {
        let mut resource = Self::new_gd();
        {
            prepare(&volume);
            let mut this = resource.bind_mut();
            this.volume = Some(volume);
            this.report = report;
            if let Some(depth) = depth {
                let _ = this.depth.set(Derived::ready(depth));
            }
        }
        resource
    }

    /// A resource that holds what was imported.
    pub fn loaded(Loaded { imported, surroundings }: Loaded) -> Gd<Self> {
        let report = report_dictionary(&imported.report);
        let mut resource = Self::of(imported.volume, report);
        resource.bind_mut().surroundings = surroundings.map(Arc::new);
        resource
    }

    /// The scan.
    pub fn volume(&self) -> Option<&Arc<Volume>> {
        self.volume.as_ref()
    }

    /// The look that suits the scan when nobody chose one.
    pub fn default_medium(&self) -> Option<&Medium> {
        let volume = self.volume.as_ref()?;
        Some(self.default_medium.get_or_init(|| Preset::default_for(volume).medium(volume)))
    }

    /// The scan's depths below the skin, which another thread computes from the first time that they are asked for; and
    /// whether that is still at it.
    pub fn depth(&self) -> (Option<Arc<Volume>>, bool) {
        let Some(volume) = &self.volume else { return (None, false) };
        let depth = self.depth.get_or_init(|| {
            let volume = volume.clone();
            Derived::compute(move || depth_of(&volume))
        });
        match depth.get() {
            Some(computed) => (computed, false),
            None => (None, true),
        }
    }

    /// A part of the scan in place of the patient, which another thread computes; `None` where that is the scan itself.
    pub fn part(&self, part: Part) -> Option<Derived> {
        self.parts.get(part, self.volume.as_ref()?, self.surroundings.as_ref())
    }

    fn set_volume(
        &mut self,
        volume: Option<Arc<Volume>>,
        surroundings: Option<Arc<Surroundings>>,
        report: VarDictionary,
    ) {
        volume.iter().for_each(prepare);
        self.volume = volume;
        self.surroundings = surroundings;
        self.report = report;
        self.histogram = OnceLock::new();
        self.default_medium = OnceLock::new();
        self.depth = OnceLock::new();
        self.parts = Parts::default();
        self.base_mut().emit_changed();
    }
}

/// Computes what every picture needs of a volume, before one does.
fn prepare(volume: &Arc<Volume>) {
    let volume = volume.clone();
    rayon::spawn(move || lumivox_renderer::prepare_volume(&volume));
}

/// Depths below the skin, where there is one.
fn depth_of(volume: &Volume) -> Option<Volume> {
    let cancel = CancelToken::new();
    let found = lumivox_segmentation::segment(volume, Progress::SILENT, &cancel).ok()?;
    if !found.report.is_sure() {
        return None;
    }
    lumivox_segmentation::skin_depth(volume, &found.labels, Progress::SILENT, &cancel).ok()
}

/// An import's report for scripts.
pub fn report_dictionary(report: &ImportReport) -> VarDictionary {
    let mut series = VarArray::new();
    for one in &report.series {
        series.push(
            &vdict! {
                "id" => one.id.as_str(),
                "name" => one.name.as_str(),
                "number" => &one.number.map_or(Variant::nil(), |n| n.to_variant()),
                "description" => one.description.as_str(),
                "files" => one.files as i64,
                "modality" => one.modality.as_str(),
                "dimensions" => dimensions(one.dims),
                "spacing_mm" => convert::vector(one.spacing_mm.into()),
                "orientation" => one.orientation.as_str(),
                "phases" => one.phases as i64,
                "unit" => one.unit.as_str(),
                "bytes" => one.bytes as i64,
                "reason" => one.reason.as_str(),
                "notes" => &sentences(&one.notes),
            }
            .to_variant(),
        );
    }
    let mut skipped = VarArray::new();
    for file in &report.skipped {
        let path = lumivox_core::words::path(&file.path);
        skipped.push(&vdict! { "path" => &*path, "reason" => file.reason.as_str() }.to_variant());
    }
    vdict! {
        "format" => report.format.as_str(),
        "series" => &series,
        "chosen" => report.chosen as i64,
        "notes" => &sentences(&report.notes),
        "skipped" => &skipped,
    }
}

fn dimensions(dims: [usize; 3]) -> Vector3i {
    let [x, y, z] = dims.map(|n| i32::try_from(n).unwrap_or(i32::MAX));
    Vector3i::new(x, y, z)
}

fn sentences(list: &[String]) -> PackedStringArray {
    list.iter().map(GString::from).collect()
}

//! What a volume's node warns of.

use godot::classes::{Engine, RenderingServer};
use godot::prelude::*;
use lumivox_core::MOST_CLIP_SHAPES;

use super::LumivoxVolume3D;
use crate::nodes::clip_3d::clip_count;
use crate::resources::LumivoxVolume;
use crate::scene_file::SCENE_EXTENSION;
use crate::{server, shared};

/// Metadata of a file that is a part of a scan: the file that the scan was imported with.
const SERIES_META: &str = "lumivox_series";

impl LumivoxVolume3D {
    /// All of it.
    pub(super) fn warnings(&self) -> Vec<GString> {
        let mut warnings = vec![];
        if plugin_is_off() {
            warnings.push(GString::from(
                "The Lumivox plugin is off: scans are not imported, and there are no handles. Switch it on in \
                 Project Settings, Plugins.",
            ));
        }
        warnings.extend(self.scan_warning().as_ref().map(GString::from));
        warnings.extend(self.look_warnings().into_iter().map(GString::from));
        warnings.extend(self.misplaced_labels().as_ref().map(GString::from));
        warnings.extend(self.hidden_paint().as_ref().map(GString::from));
        warnings.extend(self.part_warning().as_ref().map(GString::from));
        warnings.extend(self.clip_warning().as_ref().map(GString::from));
        if RenderingServer::singleton().get_rendering_device().is_none() {
            warnings.push(GString::from(server::NO_DEVICE));
        } else if let Some(error) = &shared::lock().error {
            warnings.push(GString::from(&format!("Volumes cannot be drawn: {error}.")));
        }
        if let Some(factor) = self.reduction() {
            warnings.push(GString::from(&format!(
                "The GPU has no room for all voxels of this scan: it is shown at 1/{factor} of its resolution. Free \
                 others, or crop it."
            )));
        }
        warnings
    }

    /// That there are more shapes than can cut.
    pub(super) fn clip_warning(&self) -> Option<String> {
        let count = clip_count(&self.base());
        (count > MOST_CLIP_SHAPES)
            .then(|| format!("Of its {count} LumivoxClip3D, only the first {MOST_CLIP_SHAPES} cut."))
    }

    /// Voxels of the scan along an axis for one on the GPU, where it has no room for all.
    fn reduction(&self) -> Option<u32> {
        let volume = self.shown()?.volume;
        let store = shared::lock().store.clone()?;
        let resolution = store.resolution(&volume)?;
        (!resolution.arriving && resolution.factor > 1).then_some(resolution.factor)
    }

    /// What is wrong with the scan, if anything.
    fn scan_warning(&self) -> Option<String> {
        if let Some(whole) = self.volume.as_ref().and_then(whole_scan) {
            return Some(format!(
                "'Volume' is one slice of a scan, and shows nothing. Press 'Use the Whole Scan' in the inspector, or set \
                 {whole}."
            ));
        }
        if !self.has_scan() {
            let ways = "Set 'Volume', or drop a DICOM folder on the FileSystem dock.";
            return Some(format!("There is no scan to show. {ways}"));
        }
        // That of an imported scene file is imported with it, as a model's meshes are.
        let is_in_scene = |path: GString| {
            let path = path.to_string();
            path.contains("::") && !path.contains(&format!(".{SCENE_EXTENSION}::"))
        };
        if self.labels.as_ref().is_some_and(|labels| is_in_scene(labels.get_path())) {
            return Some(
                "The labels are kept in the scene's file, which makes that large. Save them as .res: 'Save As...' in \
                 the menu of 'Labels'."
                    .to_owned(),
            );
        }
        is_in_scene(self.volume.as_ref()?.get_path()).then(|| {
            "The scan is kept in the scene's file, which makes that large and slow to open and to save. Save it as .res: \
             'Save As...' in the menu of 'Volume'."
                .to_owned()
        })
    }

    /// That the labels seem to be another scan's.
    pub(super) fn misplaced_labels(&self) -> Option<String> {
        let labels = self.labels.as_ref()?.bind();
        let resource = self.volume.as_ref()?.bind();
        let misplaced = labels.labels()?.misplaced(resource.volume()?)?;
        Some(format!("Labels: {}.", misplaced.why))
    }

    /// Says so in a game, where nobody looks at the scene dock.
    pub(super) fn tell_misplaced_labels(&self) {
        if Engine::singleton().is_editor_hint() {
            return;
        }
        if let Some(why) = self.misplaced_labels() {
            godot_warn!("LumivoxVolume3D: {why}");
        }
    }

    /// Why less is seen of the scan than there is.
    fn look_warnings(&self) -> Vec<&'static str> {
        let mut warnings = vec![];
        if self.transfer_function.as_ref().is_some_and(|function| function.bind().is_without_knots()) {
            warnings.push("The transfer function has no opacity knots: it shows nothing. Choose a preset, or add knots.");
        }
        if self.density == 0.0 {
            warnings.push("'Density' is 0: nothing is seen.");
        }
        let extent = self.clip_max - self.clip_min;
        if extent.x * extent.y * extent.z == 0.0 {
            warnings
                .push("The clip box is flat: nothing is seen. 'Clip Min' must be smaller than 'Clip Max'.");
        } else if extent.x.min(extent.y).min(extent.z) < 0.0 {
            warnings.push("'Clip Min' lies beyond 'Clip Max': what is between them is kept.");
        }
        warnings
    }
}

/// Whether the editor runs without the half of the addon that is a plugin.
fn plugin_is_off() -> bool {
    let engine = Engine::singleton();
    let editor = if engine.is_editor_hint() { engine.get_singleton("EditorInterface") } else { None };
    editor.is_some_and(|mut editor| !editor.call("is_plugin_enabled", &["lumivox".to_variant()]).booleanize())
}

/// The file of the scan of which a volume is only one slice.
pub(super) fn whole_scan(volume: &Gd<LumivoxVolume>) -> Option<String> {
    let is_slice = volume.bind().is_empty() && volume.has_meta(SERIES_META);
    is_slice.then(|| volume.get_meta(SERIES_META).stringify().to_string())
}

//! Labels of a scan as a Godot resource.

use std::sync::Arc;

use godot::classes::{IResource, Resource};
use godot::prelude::*;
use godot::register::info::{PropertyHint, PropertyHintInfo, PropertyInfo, PropertyUsageFlags};
use lumivox_core::document::Style;
use lumivox_core::labels::CutAway;
use lumivox_core::medium::{MAX_DENSITY_SCALE, SurfaceReflection};
use lumivox_core::spelling::edit_distance;
use lumivox_core::{CancelToken, LabelStyle, LabelVolume, Labelling, Progress, Volume};
use lumivox_import::{LabelOptions, load_labels};

use super::{LumivoxTransferFunction, LumivoxVolume, stored};
use crate::nodes::{LumivoxVolume3D, MAX_GRADIENT};
use crate::{convert, kept_paths};

/// Group of the inspector, and beginning of the names of its properties.
const GROUP: &str = "labels/";

/// What the parts of a scan are, and how each looks: for [member LumivoxVolume3D.labels].
///
/// Load a segmentation (DICOM SEG, NIfTI, NRRD, MetaImage) with [method load_file], or have the parts of a CT found with
/// [method found_in]. Each label has properties of its own, which the inspector shows and scripts set as
/// [code]labels.set_label("liver", "opacity", 0.3)[/code] (or [code]labels.set("labels/liver/opacity", 0.3)[/code], for
/// animations): [code]visible[/code], [code]opacity[/code] (a factor, 0 to 1),
/// [code]density[/code] (in place of the volume's; -1 is that), [code]painted[/code] and [code]color[/code] (whether
/// [code]color[/code] takes the place of the transfer function's; what that makes clear stays clear, and the volume's node warns
/// of it), [code]transfer_function[/code] (of its own), [code]clipped[/code] (whether a [LumivoxClip3D] cuts it) and
/// [code]own_surface[/code] (whether [code]surface_strength[/code], [code]surface_gradient[/code] (0 is the volume's),
/// [code]surface_roughness[/code], [code]surface_specular[/code] and [code]surface_metallic[/code] take the place of the volume's: see
/// [member LumivoxVolume3D.surface_strength]). What has no label is called [code]unlabelled[/code].
///
/// Labels may have another resolution than the scan; borders between them are smooth. Save them as a binary resource
/// ([code].res[/code]).
#[derive(GodotClass)]
#[class(tool, init, base = Resource)]
pub struct LumivoxLabels {
    #[var(rename = _stored, get = _get_stored, set = _set_stored, usage_flags = [STORAGE])]
    stored: PhantomVar<VarDictionary>,
    labels: Option<Arc<LabelVolume>>,
    looks: Vec<Look>,
    notes: Vec<String>,
    base: Base<Resource>,
}

/// How a label looks, as the inspector shows it.
struct Look {
    value: u8,
    name: String,
    visible: bool,
    opacity: f64,
    density: f64,
    painted: bool,
    color: Color,
    transfer_function: Option<Gd<LumivoxTransferFunction>>,
    clipped: bool,
    own_surface: bool,
    /// With a gradient of 0 where that is the volume's.
    surface: SurfaceReflection,
    /// What a scene file says, which has more than these: it holds as long as they are as they were then.
    exact: Option<LabelStyle>,
}

impl Look {
    fn new(value: u8, name: &str, color: [f64; 3]) -> Self {
        Self {
            value,
            // Slashes would part the inspector's tree.
            name: name.replace('/', "-"),
            visible: true,
            opacity: 1.0,
            density: -1.0,
            painted: false,
            color: convert::color_from_linear(color),
            transfer_function: None,
            clipped: true,
            own_surface: false,
            surface: LumivoxVolume3D::SURFACE,
            exact: None,
        }
    }

    /// Takes over the style of a scene file.
    fn put(&mut self, style: LabelStyle) {
        self.visible = style.visible;
        self.opacity = style.opacity;
        self.density = style.density_scale.unwrap_or(-1.0);
        self.painted = style.color.is_some();
        self.color = style.color.map_or(self.color, convert::color_from_linear);
        let function = style.transfer_function.as_ref();
        self.transfer_function = function.map(|curve| LumivoxTransferFunction::exactly(curve, &[]));
        self.clipped = style.clipped;
        self.own_surface = style.surface.is_some();
        self.surface = style.surface.unwrap_or(self.surface);
        self.exact = Some(style);
    }

    /// Whether a style is what these properties say, as far as they do.
    fn says(&self, style: &LabelStyle) -> bool {
        let color = style.color.map(convert::color_from_linear);
        let function = self.transfer_function.as_ref().map(|function| function.bind().curve());
        self.visible == style.visible
            && self.opacity == style.opacity
            && self.density == style.density_scale.unwrap_or(-1.0)
            && self.painted.then_some(self.color) == color
            && function == style.transfer_function
            && self.clipped == style.clipped
            && self.own_surface.then_some(self.surface) == style.surface
    }

    /// Its style in a volume of this surface.
    fn style(&self, of_volume: SurfaceReflection) -> LabelStyle {
        if let Some(exact) = self.exact.as_ref().filter(|exact| self.says(exact)) {
            return exact.clone();
        }
        LabelStyle {
            visible: self.visible,
            color: self.painted.then(|| convert::linear_from_color(self.color)),
            transfer_function: self.transfer_function.as_ref().map(|function| function.bind().curve()),
            density_scale: (self.density >= 0.0).then_some(self.density),
            opacity: self.opacity,
            surface: self.own_surface.then_some(match self.surface {
                own if own.gradient_per_mm > 0.0 => own,
                own => SurfaceReflection { gradient_per_mm: of_volume.gradient_per_mm, ..own },
            }),
            clipped: self.clipped,
        }
    }

    fn get(&self, field: &str) -> Option<Variant> {
        Some(match field {
            "visible" => self.visible.to_variant(),
            "opacity" => self.opacity.to_variant(),
            "density" => self.density.to_variant(),
            "painted" => self.painted.to_variant(),
            "color" => self.color.to_variant(),
            "transfer_function" => self.transfer_function.to_variant(),
            "clipped" => self.clipped.to_variant(),
            "own_surface" => self.own_surface.to_variant(),
            "surface_strength" => self.surface.strength.to_variant(),
            "surface_gradient" => self.surface.gradient_per_mm.to_variant(),
            "surface_roughness" => self.surface.roughness.to_variant(),
            "surface_specular" => self.surface.specular.to_variant(),
            "surface_metallic" => self.surface.metallic.to_variant(),
            _ => return None,
        })
    }

    /// Whether there is such a field, and the value is one for it.
    fn set(&mut self, field: &str, value: &Variant) -> bool {
        let number = || value.try_to::<f64>().ok().filter(|x| x.is_finite());
        let surface = &mut self.surface;
        let mut put = |part: fn(&mut SurfaceReflection) -> &mut f64, most: f64| {
            number().map(|x| *part(surface) = x.clamp(0.0, most)).is_some()
        };
        match field {
            "visible" => value.try_to().map(|is| self.visible = is).is_ok(),
            "painted" => value.try_to().map(|is| self.painted = is).is_ok(),
            "clipped" => value.try_to().map(|is| self.clipped = is).is_ok(),
            "own_surface" => value.try_to().map(|is| self.own_surface = is).is_ok(),
            "surface_strength" => put(|surface| &mut surface.strength, 1.0),
            "surface_gradient" => put(|surface| &mut surface.gradient_per_mm, MAX_GRADIENT),
            "surface_roughness" => put(|surface| &mut surface.roughness, 1.0),
            "surface_specular" => put(|surface| &mut surface.specular, 1.0),
            "surface_metallic" => put(|surface| &mut surface.metallic, 1.0),
            "color" => value.try_to().map(|color| self.color = color).is_ok(),
            "transfer_function" => value.try_to().map(|function| self.transfer_function = function).is_ok(),
            "opacity" => number().map(|x| self.opacity = x.clamp(0.0, 1.0)).is_some(),
            "density" => number().map(|x| self.density = x.clamp(-1.0, MAX_DENSITY_SCALE)).is_some(),
            _ => false,
        }
    }
}

const FIELDS: [&str; 13] = [
    "visible",
    "opacity",
    "density",
    "painted",
    "color",
    "transfer_function",
    "clipped",
    "own_surface",
    "surface_strength",
    "surface_gradient",
    "surface_roughness",
    "surface_specular",
    "surface_metallic",
];

#[godot_api]
impl LumivoxLabels {
    /// Loads a segmentation and waits for it: a DICOM SEG file or a folder with one, a NIfTI, NRRD or MetaImage file of
    /// labels. Returns [code]null[/code] and says why in the output if it cannot be loaded.
    #[func]
    pub fn load_file(path: GString) -> Option<Gd<Self>> {
        let file = convert::system_path(&path);
        match load_labels(&file, &LabelOptions::default(), Progress::SILENT, &CancelToken::new()) {
            Ok(loaded) => Some(Self::of(loaded.labels, loaded.report.notes)),
            Err(error) => {
                godot_error!("{error}");
                None
            }
        }
    }

    /// What is found in a scan by itself: of a CT the body, lungs, airways and gas, table and clothes; of an MR the body.
    /// Takes seconds for a large scan: [method LumivoxImporter.find_labels] does it without holding up anything, and can be
    /// cancelled. [code]null[/code] for a volume without a scan and, with an error in the output, for none.
    #[func]
    pub fn found_in(volume: Option<Gd<LumivoxVolume>>) -> Option<Gd<Self>> {
        let Some(volume) = volume else {
            godot_error!("LumivoxLabels.found_in: there is no volume to look in; the scan was not loaded");
            return None;
        };
        let scan = volume.bind().volume()?.clone();
        let found = lumivox_segmentation::segment(&scan, Progress::SILENT, &CancelToken::new()).ok()?;
        Some(Self::of(found.labels, found.report.notes))
    }

    /// What is to be known of where they came from, as sentences: how sure it is where they were found, what was changed
    /// where they were loaded. Empty once they were saved.
    #[func]
    pub fn get_notes(&self) -> PackedStringArray {
        self.notes.iter().map(GString::from).collect()
    }

    /// The files that the labels were loaded from; empty where they were found in a scan or made otherwise. They are kept when
    /// the labels are saved, as those of a [LumivoxVolume] are.
    #[func]
    pub fn get_source_files(&self) -> PackedStringArray {
        let source = self.labels.as_ref().and_then(|labels| labels.source());
        kept_paths::shown_paths(source.into_iter().flat_map(|source| &source.files))
    }

    /// Forgets what files the labels come from, which may be called by a patient's name. A scene with them cannot be saved
    /// any more.
    #[func]
    pub fn forget_source(&mut self) {
        if let Some(labels) = self.labels.take() {
            self.labels = Some(Arc::new(Arc::unwrap_or_clone(labels).without_source()));
            self.base_mut().emit_changed();
        }
    }

    /// The names of the labels; of what has none, [code]unlabelled[/code].
    #[func]
    pub fn get_names(&self) -> PackedStringArray {
        self.looks.iter().map(|look| GString::from(&look.name)).collect()
    }

    /// Sets how a label looks: [code]set_label("liver", "visible", false)[/code]. Returns whether it could; if not, an error in
    /// the output names the nearest label or field that there is, and nothing changes.
    #[func]
    fn set_label(&mut self, name: GString, field: GString, value: Variant) -> bool {
        self.set_field(&name.to_string(), &field.to_string(), &value)
    }

    /// How a label looks, by the names of [method set_label]; [code]null[/code] and an error where there is no such label or
    /// field.
    #[func]
    fn get_label(&self, name: GString, field: GString) -> Variant {
        let (name, field) = (name.to_string(), field.to_string());
        let found = self.look(&name).and_then(|look| {
            look.get(&field).ok_or_else(|| format!("A label has no '{field}'{}", nearest(&field, FIELDS)))
        });
        found.unwrap_or_else(|why| {
            godot_error!("LumivoxLabels: {why}");
            Variant::nil()
        })
    }

    #[func]
    fn _get_stored(&self) -> VarDictionary {
        let Some(labels) = &self.labels else { return VarDictionary::new() };
        let mut names = PackedStringArray::new();
        let mut colors = PackedColorArray::new();
        let mut values = PackedByteArray::new();
        for label in labels.labels() {
            values.push(label.value);
            names.push(&GString::from(&label.name));
            colors.push(convert::color_from_linear(label.color));
        }
        let mut stored = stored::to_dictionary(labels.volume(), &VarDictionary::new());
        stored.set("label_values", &values);
        stored.set("label_names", &names);
        stored.set("label_colors", &colors);
        if let Some(source) = labels.source() {
            stored::put_label_source(&mut stored, source);
        }
        if let Some(text) = labels.cut_away().and_then(|cut| serde_json::to_string(cut).ok()) {
            stored.set("cut_away", text.as_str());
        }
        let exact = |look: &Look| look.exact.as_ref().map(|exact| Style::of(look.value.to_string(), exact));
        let exact: Vec<Style> = self.looks.iter().filter_map(exact).collect();
        if let Some(text) = serde_json::to_string(&exact).ok().filter(|_| !exact.is_empty()) {
            stored.set("exact_styles", text.as_str());
        }
        stored
    }

    #[func]
    fn _set_stored(&mut self, stored: VarDictionary) {
        if stored.is_empty() {
            return;
        }
        match from_dictionary(&stored) {
            Ok(labels) => {
                let styles = exact_styles(&stored, &labels);
                self.put(labels);
                self.put_styles(styles);
            }
            Err(why) => {
                let path = self.base().get_path();
                godot_error!("The labels {path} cannot be used: {why}. Load the segmentation again.");
            }
        }
    }
}

#[godot_api]
impl IResource for LumivoxLabels {
    fn on_get_property_list(&mut self) -> Vec<PropertyInfo> {
        let of = |look: &Look| {
            FIELDS.map(|field| {
                let name = format!("{GROUP}{}/{field}", look.name);
                let property = match field {
                    "opacity" | "surface_strength" | "surface_roughness" | "surface_specular"
                    | "surface_metallic" => PropertyInfo::new_export::<f64>(&name)
                        .with_hint_info(hint(PropertyHint::RANGE, "0,1,0.001")),
                    "surface_gradient" => PropertyInfo::new_export::<f64>(&name)
                        .with_hint_info(hint(PropertyHint::RANGE, "0,1000,0.1,or_greater,suffix:/mm")),
                    "density" => PropertyInfo::new_export::<f64>(&name)
                        .with_hint_info(hint(PropertyHint::RANGE, "-1,100,0.001,or_greater")),
                    "color" => PropertyInfo::new_export::<Color>(&name)
                        .with_hint_info(hint(PropertyHint::COLOR_NO_ALPHA, "")),
                    "transfer_function" => {
                        PropertyInfo::new_export::<Option<Gd<LumivoxTransferFunction>>>(&name)
                    }
                    _ => PropertyInfo::new_export::<bool>(&name),
                };
                // Kept, but not shown where it has no say.
                let is_shown = look.own_surface || !field.starts_with("surface_");
                let usage = if is_shown { property.usage } else { PropertyUsageFlags::STORAGE };
                PropertyInfo { usage, ..property }
            })
        };
        self.looks.iter().flat_map(of).collect()
    }

    fn on_get(&self, property: StringName) -> Option<Variant> {
        let property = property.to_string();
        let (name, field) = property.strip_prefix(GROUP)?.rsplit_once('/')?;
        self.looks.iter().find(|look| look.name == name)?.get(field)
    }

    fn on_set(&mut self, property: StringName, value: Variant) -> bool {
        let property = property.to_string();
        let Some((name, field)) = property.strip_prefix(GROUP).and_then(|rest| rest.rsplit_once('/')) else {
            return false;
        };
        // What is refused was said: the engine itself would say nothing.
        self.set_field(name, field, &value);
        true
    }
}

impl LumivoxLabels {
    /// A resource that holds labels.
    pub fn of(labels: LabelVolume, notes: Vec<String>) -> Gd<Self> {
        let mut resource = Self::new_gd();
        resource.bind_mut().put(labels);
        resource.bind_mut().notes = notes;
        resource
    }

    /// A resource that looks as a scene file says.
    pub fn exactly(labelling: &Labelling) -> Gd<Self> {
        let mut resource = Self::of((*labelling.labels).clone(), vec![]);
        resource.bind_mut().labels = Some(labelling.labels.clone());
        resource.bind_mut().put_styles(labelling.styles.to_vec());
        resource
    }

    fn put_styles(&mut self, styles: Vec<(u8, LabelStyle)>) {
        for (value, style) in styles {
            if let Some(look) = self.looks.iter_mut().find(|look| look.value == value) {
                look.put(style);
            }
        }
    }

    fn look(&self, name: &str) -> Result<&Look, String> {
        let names = || self.looks.iter().map(|look| look.name.as_str());
        let found = self.looks.iter().find(|look| look.name == name);
        found.ok_or_else(|| format!("there is no label '{name}'{}", nearest(name, names())))
    }

    /// Sets a field of a label's look; returns whether it could, or says why not.
    fn set_field(&mut self, name: &str, field: &str, value: &Variant) -> bool {
        let refused = match self.look(name) {
            Err(why) => Some(why),
            Ok(_) if !FIELDS.contains(&field) => {
                Some(format!("a label has no '{field}'{}", nearest(field, FIELDS)))
            }
            Ok(_) => {
                let look = self.looks.iter_mut().find(|look| look.name == name);
                let is_set = look.is_some_and(|look| look.set(field, value));
                (!is_set).then(|| format!("'{field}' of the label '{name}' cannot be {value}"))
            }
        };
        match &refused {
            None if field == "own_surface" => {
                self.base_mut().notify_property_list_changed();
                self.base_mut().emit_changed();
            }
            None => self.base_mut().emit_changed(),
            Some(why) => godot_error!("LumivoxLabels: {why}."),
        }
        refused.is_none()
    }

    fn put(&mut self, labels: LabelVolume) {
        let named = labels.own_labels().map(|label| Look::new(label.value, &label.name, label.color));
        self.looks = named.chain([Look::new(lumivox_core::UNLABELLED, "unlabelled", [1.0; 3])]).collect();
        self.labels = Some(Arc::new(labels));
        self.base_mut().notify_property_list_changed();
        self.base_mut().emit_changed();
    }

    /// What the labels are.
    pub fn labels(&self) -> Option<&Arc<LabelVolume>> {
        self.labels.as_ref()
    }

    /// Value, name and style of each label that is painted and would be seen by its own settings.
    pub fn painted(&self) -> impl Iterator<Item = (u8, &str, LabelStyle)> {
        let is_meant =
            |look: &&Look| look.painted && look.visible && look.opacity > 0.0 && look.density != 0.0;
        // Their surfaces are of no interest: nobody is told of them.
        let style = |look: &Look| look.style(SurfaceReflection::OFF);
        self.looks.iter().filter(is_meant).map(move |look| (look.value, look.name.as_str(), style(look)))
    }

    /// The labels and their looks in a volume of a surface; `None` without any.
    pub fn labelling(&self, of_volume: SurfaceReflection) -> Option<Labelling> {
        let labels = self.labels.clone()?;
        let styles = self.looks.iter().map(|look| (look.value, look.style(of_volume)));
        let styles = styles.filter(|(_, style)| *style != LabelStyle::default()).collect();
        Some(Labelling { labels, styles }.without_cut())
    }
}

/// Words that name what is spelt most alike, and all there are where they are few.
fn nearest<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let distance = |name: &str| edit_distance(&wanted.to_lowercase(), &name.to_lowercase());
    match known.iter().min_by_key(|name| distance(name)) {
        None => ": it has no labels yet".to_owned(),
        Some(name) if known.len() > 12 => format!("; the nearest is '{name}'"),
        Some(name) => format!("; the nearest is '{name}', there are '{}'", known.join("', '")),
    }
}

fn hint(hint: PropertyHint, text: &str) -> PropertyHintInfo {
    PropertyHintInfo { hint, hint_string: GString::from(text) }
}

/// The styles of a scene file that were saved with labels.
fn exact_styles(stored: &VarDictionary, labels: &LabelVolume) -> Vec<(u8, LabelStyle)> {
    let text = stored.get("exact_styles").map(|text| text.stringify().to_string()).unwrap_or_default();
    let styles: Vec<Style> = serde_json::from_str(&text).unwrap_or_default();
    let style = |style: &Style| {
        let mut all = LabelStyle::default();
        style.apply(None, labels.volume(), SurfaceReflection::OFF, &mut all);
        Some((style.label.parse().ok()?, all))
    };
    styles.iter().filter_map(style).collect()
}

fn from_dictionary(stored: &VarDictionary) -> Result<LabelVolume, String> {
    let (volume, _): (Volume, _) = stored::from_dictionary(stored)?;
    let entry = |key: &str| stored.get(key).ok_or_else(|| format!("it lacks '{key}'"));
    let wrong = |_| "its names and colours are of another kind".to_owned();
    let values: PackedByteArray = entry("label_values")?.try_to().map_err(wrong)?;
    let names: PackedStringArray = entry("label_names")?.try_to().map_err(wrong)?;
    let colors: PackedColorArray = entry("label_colors")?.try_to().map_err(wrong)?;
    let all = values.as_slice().iter().zip(names.as_slice()).zip(colors.as_slice());
    let table = all.map(|((&value, name), &color)| lumivox_core::Label {
        value,
        name: name.to_string(),
        color: convert::linear_from_color(color).map(|c| c.clamp(0.0, 1.0)),
    });
    let place = volume.patient_from_voxel();
    let voxels = volume.voxels().as_bytes().to_vec();
    let labels = LabelVolume::new(volume.dims(), voxels, place, table.collect());
    let labels = labels.map_err(|error| error.to_string())?;
    // Older files have neither.
    let labels = match stored::label_source(stored) {
        Some(source) => labels.with_source(source),
        None => labels,
    };
    let text = stored.get("cut_away").map(|text| text.stringify().to_string()).unwrap_or_default();
    Ok(match serde_json::from_str::<CutAway>(&text) {
        Ok(cut) => labels.with_cut(cut),
        Err(_) => labels,
    })
}

//! The node that cuts volumes open.

use godot::classes::notify::Node3DNotification;
use godot::classes::{Engine, INode3D, Node, Node3D};
use godot::prelude::*;
use lumivox_core::MOST_CLIP_SHAPES;
use lumivox_core::glam::DAffine3;
use lumivox_core::{ClipKind, ClipShape};

use super::LumivoxVolume3D;
use crate::convert;

/// Cuts its parent, a [LumivoxVolume3D], open: of the scan, what the shape keeps is seen. Up to 64 may be children of a
/// volume, moved and turned at will; what each of them keeps is seen.
///
/// The cut shows tissue as it is inside, shaded as a surface. Labels of [member LumivoxVolume3D.labels] can be spared.
#[derive(GodotClass)]
#[class(tool, init, base = Node3D)]
pub struct LumivoxClip3D {
    /// What is kept: [constant SHAPE_PLANE], [constant SHAPE_BOX] or [constant SHAPE_SPHERE].
    #[export(enum = (Plane, Box, Sphere))]
    #[var(set)]
    shape: i64,
    /// Whether what the shape would keep is cut away, and the rest kept.
    #[export]
    #[var(set)]
    inverted: bool,
    // Where a scene file has the shape in the patient, to more digits than the node's own: it holds as long as the node is there.
    #[var(rename = _exact, get = _get_exact, set = _set_exact, usage_flags = [STORAGE, INTERNAL])]
    exact: PackedFloat64Array,
    base: Base<Node3D>,
}

#[godot_api]
impl LumivoxClip3D {
    /// [member shape] that keeps what lies on the side of the node's +y axis, whatever its scale.
    #[constant]
    pub const SHAPE_PLANE: i64 = 0;
    /// [member shape] that keeps what lies within a cube of one metre about the node's origin; its scale makes it a box.
    #[constant]
    pub const SHAPE_BOX: i64 = 1;
    /// [member shape] that keeps what lies within half a metre of the node's origin; its scale makes it an ellipsoid.
    #[constant]
    pub const SHAPE_SPHERE: i64 = 2;

    #[func]
    fn set_shape(&mut self, shape: i64) {
        self.shape = shape.clamp(Self::SHAPE_PLANE, Self::SHAPE_SPHERE);
        let is_untouched = self.base().get_transform() == Transform3D::IDENTITY;
        if is_untouched && self.base().is_inside_tree() && Engine::singleton().is_editor_hint() {
            self.fit_to_volume();
        }
        self.base_mut().update_gizmos();
        self.changed();
    }

    /// Places and scales the node so that a box or sphere is as large as what is kept of the volume above it; a plane goes
    /// through its middle. In the editor new ones are. Returns whether the parent is a [LumivoxVolume3D] with a scan.
    #[func]
    fn fit_to_volume(&mut self) -> bool {
        let Some(volume) = self.parent_volume() else { return false };
        let volume = volume.bind();
        let (low, high) = (volume.clip_corner(false), volume.clip_corner(true));
        let place =
            volume.get_clip_transform() * Transform3D::new(Basis::from_scale(high - low), (low + high) / 2.0);
        let has_scan = volume.get_local_box().has_volume();
        drop(volume);
        if has_scan {
            let place = match self.shape {
                Self::SHAPE_PLANE => Transform3D::new(Basis::IDENTITY, place.origin),
                Self::SHAPE_BOX => place,
                _ => {
                    let size = place.basis.get_scale();
                    Transform3D::new(
                        Basis::from_scale(Vector3::splat(size.x.max(size.y).max(size.z))),
                        place.origin,
                    )
                }
            };
            self.base_mut().set_transform(place);
        }
        has_scan
    }

    #[func]
    fn _get_exact(&self) -> PackedFloat64Array {
        self.exact.clone()
    }

    #[func]
    fn _set_exact(&mut self, numbers: PackedFloat64Array) {
        self.exact = numbers;
    }

    #[func]
    fn set_inverted(&mut self, inverted: bool) {
        self.inverted = inverted;
        self.base_mut().update_gizmos();
        self.changed();
    }
}

#[godot_api]
impl INode3D for LumivoxClip3D {
    fn on_notification(&mut self, what: Node3DNotification) {
        match what {
            Node3DNotification::ENTER_TREE => {
                self.base_mut().set_notify_transform(true);
                self.changed();
                // The editor shows what its volume warns of.
                let count = self.parent_volume().map_or(0, |volume| clip_count(&volume));
                if count == MOST_CLIP_SHAPES + 1 && !Engine::singleton().is_editor_hint() {
                    godot_warn!(
                        "LumivoxClip3D: {MOST_CLIP_SHAPES} cut a volume at most, and the others do not."
                    );
                }
            }
            Node3DNotification::EXIT_TREE
            | Node3DNotification::TRANSFORM_CHANGED
            | Node3DNotification::VISIBILITY_CHANGED => self.changed(),
            _ => {}
        }
    }

    fn get_configuration_warnings(&self) -> PackedStringArray {
        let is_child = self.parent_volume().is_some();
        let warning = "It cuts nothing: its parent must be a LumivoxVolume3D.";
        (!is_child).then(|| GString::from(warning)).into_iter().collect()
    }
}

impl LumivoxClip3D {
    /// The node of a scene file's shape, for a child of its volume's node.
    pub fn opened(shape: &ClipShape, node_from_patient: DAffine3) -> Gd<Self> {
        let mut node = Self::new_alloc();
        let kind = match shape.kind {
            ClipKind::Plane => Self::SHAPE_PLANE,
            ClipKind::Box => Self::SHAPE_BOX,
            ClipKind::Sphere => Self::SHAPE_SPHERE,
        };
        {
            let mut this = node.bind_mut();
            (this.shape, this.inverted) = (kind, shape.inverted);
            this.exact = convert::numbers(shape.patient_from_shape);
        }
        let place = node_from_patient * shape.patient_from_shape * own_from_shape(kind).1.inverse();
        node.set_transform(convert::transform(place));
        node
    }

    /// The shape for a volume whose millimetres are those of the patient; `None` while the node is hidden.
    pub fn shape(&self, world_from_patient: DAffine3, volume_from_patient: DAffine3) -> Option<ClipShape> {
        if !self.base().is_visible() {
            return None;
        }
        let (kind, node_from_shape) = own_from_shape(self.shape);
        let exact = convert::affine_of(self.exact.as_slice()).filter(|exact| {
            let place = volume_from_patient * *exact * node_from_shape.inverse();
            convert::transform(place) == self.base().get_transform()
        });
        let rounded = || {
            let world_from_node = convert::affine(self.to_gd().get_global_transform_interpolated());
            world_from_patient.inverse() * world_from_node * node_from_shape
        };
        let patient_from_shape = exact.unwrap_or_else(rounded);
        Some(ClipShape { kind, patient_from_shape, inverted: self.inverted })
    }

    fn parent_volume(&self) -> Option<Gd<LumivoxVolume3D>> {
        self.base().get_parent()?.try_cast().ok()
    }

    fn changed(&self) {
        if let Some(volume) = self.parent_volume() {
            // Not now: the volume may be the one that is moving.
            volume.clone().call_deferred("_contents_changed", &[]);
        }
    }
}

/// What a shape is called below, and the node's own space from that of the shape.
fn own_from_shape(shape: i64) -> (ClipKind, DAffine3) {
    match shape {
        // Its z is the node's y.
        LumivoxClip3D::SHAPE_PLANE => {
            (ClipKind::Plane, DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2))
        }
        LumivoxClip3D::SHAPE_BOX => (ClipKind::Box, half_metre()),
        _ => (ClipKind::Sphere, half_metre()),
    }
}

/// What the children of a volume's node keep of it; `volume_from_patient` leads to that node's space.
pub fn clip_shapes_of(
    volume: &Node,
    world_from_patient: DAffine3,
    volume_from_patient: DAffine3,
) -> Vec<ClipShape> {
    let children = volume.get_children();
    let clips = children.iter_shared().filter_map(|child| child.try_cast::<LumivoxClip3D>().ok());
    clips
        .filter_map(|clip| clip.bind().shape(world_from_patient, volume_from_patient))
        .take(MOST_CLIP_SHAPES)
        .collect()
}

/// How many visible shapes there are that cut a volume, or would.
pub fn clip_count(volume: &Node) -> usize {
    let children = volume.get_children();
    let clips = children.iter_shared().filter_map(|child| child.try_cast::<LumivoxClip3D>().ok());
    clips.filter(|clip| clip.is_visible()).count()
}

fn half_metre() -> DAffine3 {
    DAffine3::from_scale(lumivox_core::glam::DVec3::splat(0.5))
}

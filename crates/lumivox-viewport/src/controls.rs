//! What a mouse does to the camera: profiles of buttons, and gestures that change an orbit.

use std::f64::consts::{FRAC_PI_2, PI};

use lumivox_core::glam::DVec3;
use lumivox_core::{Orbit, PerspectiveCamera, Scene, VolumeInstance};

/// A button of a mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// The left one, for most people.
    Primary,
    /// The wheel.
    Middle,
    /// The right one, for most people.
    Secondary,
}

/// Keys that are held while a mouse is dragged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Held {
    /// Shift.
    pub shift: bool,
    /// Ctrl, or the Mac's command key.
    pub command: bool,
}

/// What dragging does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gesture {
    /// The camera goes around what it looks at.
    Turn,
    /// What is seen moves with the pointer.
    Pan,
    /// The camera comes closer or goes away.
    Dolly,
}

/// What dragging does in a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SliceGesture {
    /// Level and width of the window.
    Window,
    /// What is seen moves with the pointer.
    Pan,
    /// What is seen becomes larger or smaller.
    Zoom,
    /// The point that all views share follows the pointer.
    Cross,
}

/// Which button does what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Profile {
    /// What people know it by.
    pub name: &'static str,
    buttons: &'static [(Button, Held, Gesture)],
    slices: &'static [(Button, Held, SliceGesture)],
}

const NOTHING: Held = Held { shift: false, command: false };
const SHIFT: Held = Held { shift: true, command: false };
const COMMAND: Held = Held { shift: false, command: true };

impl Profile {
    /// As in OHIF's viewers; with Shift and Ctrl for those who have one button.
    pub const OHIF: Self = Self {
        name: "OHIF",
        buttons: &[
            (Button::Primary, NOTHING, Gesture::Turn),
            (Button::Middle, NOTHING, Gesture::Pan),
            (Button::Secondary, NOTHING, Gesture::Dolly),
            (Button::Primary, SHIFT, Gesture::Pan),
            (Button::Primary, COMMAND, Gesture::Dolly),
        ],
        slices: &[
            (Button::Primary, NOTHING, SliceGesture::Window),
            (Button::Middle, NOTHING, SliceGesture::Pan),
            (Button::Secondary, NOTHING, SliceGesture::Zoom),
            (Button::Primary, SHIFT, SliceGesture::Cross),
            (Button::Primary, COMMAND, SliceGesture::Zoom),
        ],
    };

    /// As in 3D Slicer, whose slices have their window by Ctrl and the left button.
    pub const SLICER: Self = Self {
        name: "3D Slicer",
        buttons: &[
            (Button::Primary, NOTHING, Gesture::Turn),
            (Button::Middle, NOTHING, Gesture::Pan),
            (Button::Secondary, NOTHING, Gesture::Dolly),
            (Button::Primary, SHIFT, Gesture::Pan),
            (Button::Secondary, SHIFT, Gesture::Pan),
        ],
        slices: &[
            (Button::Primary, NOTHING, SliceGesture::Cross),
            (Button::Middle, NOTHING, SliceGesture::Pan),
            (Button::Secondary, NOTHING, SliceGesture::Zoom),
            (Button::Primary, SHIFT, SliceGesture::Pan),
            (Button::Primary, COMMAND, SliceGesture::Window),
        ],
    };

    /// What a button does in a slice while these keys are held.
    pub fn slice_gesture(&self, button: Button, held: Held) -> Option<SliceGesture> {
        let of = self.slices.iter().find(|(known, keys, _)| (*known, *keys) == (button, held));
        of.map(|(_, _, gesture)| *gesture)
    }

    /// What a button does while these keys are held.
    pub fn gesture(&self, button: Button, held: Held) -> Option<Gesture> {
        let of = self.buttons.iter().find(|(known, keys, _)| (*known, *keys) == (button, held));
        of.map(|(_, _, gesture)| *gesture)
    }
}

/// Closer than this the camera does not come, in metres, and not farther than that.
const DISTANCES: [f64; 2] = [0.005, 50.0];

impl Gesture {
    /// Applies a drag: to the right and down, in heights of the view, so that all views feel alike.
    pub fn apply(self, orbit: &mut Orbit, [right, down]: [f64; 2]) {
        match self {
            Self::Turn => {
                orbit.azimuth = (orbit.azimuth - right * PI).rem_euclid(2.0 * PI);
                // The poles are left out: there the vertical has no direction in the image.
                orbit.elevation = (orbit.elevation + down * PI).clamp(0.01 - FRAC_PI_2, FRAC_PI_2 - 0.01);
            }
            Self::Pan => {
                let axes = orbit.camera().world_from_camera.matrix3;
                let height = 2.0 * orbit.distance * (orbit.vertical_fov / 2.0).tan();
                orbit.target += (axes.y_axis * down - axes.x_axis * right) * height;
            }
            Self::Dolly => approach(orbit, 3.0 * down),
        }
    }

    /// Two fingers: what is seen moves with them (to the right and down, in heights of the view), grows as they part, and turns about
    /// the vertical as they turn, in radians clockwise.
    pub fn fingers(orbit: &mut Orbit, moved: [f64; 2], zoom: f64, turned: f64) {
        Self::Pan.apply(orbit, moved);
        approach(orbit, zoom.max(1e-3).ln());
        Self::Turn.apply(orbit, [turned / PI, 0.0]);
    }

    /// Turns of a wheel, away from the hand: closer.
    pub fn wheel(orbit: &mut Orbit, notches: f64) {
        approach(orbit, 0.1 * notches);
    }
}

/// Comes closer by so many e-foldings.
fn approach(orbit: &mut Orbit, by: f64) {
    orbit.distance = (orbit.distance * (-by).exp()).clamp(DISTANCES[0], DISTANCES[1]);
}

/// Where the middle of a scene's first volume is in the world; the origin where there is none.
pub fn center_of(scene: &Scene) -> DVec3 {
    let of = |it: &VolumeInstance| it.world_from_box().transform_point3(DVec3::splat(0.5));
    scene.volumes.first().map(of).unwrap_or_default()
}

/// A camera as one that turns around what it has before it, about as far away as `center`. What it is rolled by is lost.
pub fn orbit_of(camera: &PerspectiveCamera, center: DVec3) -> Orbit {
    let eye = camera.world_from_camera.translation;
    let back = camera.world_from_camera.matrix3.z_axis.normalize();
    let distance = (eye - center).dot(back).clamp(DISTANCES[0], DISTANCES[1]);
    Orbit {
        target: eye - distance * back,
        azimuth: back.x.atan2(back.z),
        elevation: back.y.clamp(-1.0, 1.0).asin(),
        distance,
        vertical_fov: camera.vertical_fov,
    }
}

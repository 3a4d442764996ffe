//! What a host tells a live view, and what it is told.

use super::fog::Fog;
use crate::recording::ResourceId;

/// What a live view shows, besides scene and camera.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LiveSettings {
    /// Pixels of the host's image across and down.
    pub size: [u32; 2],
    /// Pixels of the film per pixel of the host along a side; 0.1 to 1.
    pub resolution_scale: f64,
    /// Samples per pixel after which the image is done.
    pub target_samples: u32,
    /// Noise at which it is done before, as [`Film::noise`](crate::Film::noise) measures it: a fraction of the brightness. 0:
    /// by its samples alone. The film is looked at after 16 samples, and again when it should be as clean; that it comes
    /// back costs a moment.
    pub target_noise: f64,
    /// Multiplies the light.
    pub exposure: f64,
    /// Linear RGB radiance from everywhere besides the scene's environment, as the volumes receive it: for light that
    /// differs from view to view, such as what a host shows equally bright at any exposure.
    pub ambient: [f64; 3],
    /// Chooses the random numbers.
    pub seed: u32,
    /// Bounces before Russian roulette may end a path.
    pub roulette_start: u32,
    /// Whether noise is filtered out of what is shown of a film at rest that has few samples, less than 256. Biased until then; the
    /// film itself never is. Where [light is kept](Self::kept_light) that is so anyway until the picture ends: there this counts
    /// for pictures that end before, by [samples](Self::target_samples) or [noise](Self::target_noise). While something moves it
    /// changes nothing: a coarse picture is always filtered.
    pub denoise: bool,
    /// Whether light is kept in the volumes, for pictures while something moves: next to none of their noise is left, at any
    /// budget. Biased, and shown only until the film has so many samples that it is better: a picture at rest is the film's. On by
    /// default. Where its buffers are too large for the device, or find no [room](crate::VoxelStore::set_capacity) beside the voxels,
    /// views do without: [`LiveStatus::light_bytes`] says so.
    pub kept_light: bool,
    /// Whether the fine film also keeps first-hit [albedo](super::LiveImage::Albedo) and [normal](super::LiveImage::Normal), for a
    /// host that denoises or scales by itself. View depth comes with every film. That takes a kernel of its own, see
    /// [`ViewKind::Live`](crate::ViewKind::Live), and 32 bytes a pixel more: in all 68 of the buffers that a device binds, so that
    /// 1920 x 1080 are too many for one with no more than WebGPU's default. When it changes the image starts over.
    pub guides: bool,
}

impl LiveSettings {
    /// Full resolution, 512 samples.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            size: [width, height],
            resolution_scale: 1.0,
            target_samples: 512,
            target_noise: 0.0,
            exposure: 1.0,
            ambient: [0.0; 3],
            seed: 0,
            roulette_start: 4,
            denoise: false,
            kept_light: true,
            guides: false,
        }
    }

    /// The same with changes.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    pub(super) fn film_size(&self) -> [u32; 2] {
        let scale =
            if self.resolution_scale.is_finite() { self.resolution_scale.clamp(0.1, 1.0) } else { 1.0 };
        self.size.map(|n| ((f64::from(n) * scale).round() as u32).max(1))
    }
}

/// The host's depth, as primary rays meet it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostDepth {
    /// A texture of one sample that can be loaded from.
    pub texture: ResourceId,
    /// `[a, b, c, d]`: view depth in metres is `(a z + b) / (c z + d)` where the texture holds `z`.
    pub view_depth_from_ndc: [f64; 4],
    /// What the texture holds where nothing was drawn.
    pub clear: f64,
    /// Whether the host moves its camera by fractions of a pixel from frame to frame.
    pub jittered: bool,
}

impl HostDepth {
    /// Depth of a camera that stays where it is from frame to frame.
    pub fn new(texture: ResourceId, view_depth_from_ndc: [f64; 4], clear: f64) -> Self {
        Self { texture, view_depth_from_ndc, clear, jittered: false }
    }

    /// Of one that moves by fractions of a pixel, if it does.
    pub fn with_jitter(self, jittered: bool) -> Self {
        Self { jittered, ..self }
    }
}

/// Where a host keeps how far what is seen at each pixel has moved, for temporal antialiasing and upscaling.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostVelocity {
    /// A colour that can be drawn to, of two floats at least: from where a point is to where it was in the frame before.
    pub texture: ResourceId,
    /// What half of the image across, and down, is in its numbers.
    pub scale: [f64; 2],
}

impl HostVelocity {
    /// From where a point is to where it was, in numbers by which half of the image is `scale` across and down: `[0.5, 0.5]` where the
    /// image is 1 wide and high, and its y grows downwards.
    pub fn new(texture: ResourceId, scale: [f64; 2]) -> Self {
        Self { texture, scale }
    }
}

/// What a host lends for one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostFrame {
    /// What ends primary rays, if anything does.
    pub depth: Option<HostDepth>,
    /// The colour that the volumes are blended over, scene-linear.
    pub color_target: ResourceId,
    /// Where the volumes' depth is written, if anywhere; not the texture of [`HostFrame::depth`] while a host cannot
    /// write what it reads.
    pub depth_target: Option<ResourceId>,
    /// Where it is written how far the volumes have moved since the frame before, if anywhere: one that the host draws is one that is
    /// recorded. Only with [`HostFrame::depth`]; of volumes that move apart each counts as still.
    pub velocity: Option<HostVelocity>,
    /// What it lays over what is far or low.
    pub fog: Option<Fog>,
}

impl HostFrame {
    /// Volumes over a colour, and nothing else.
    pub fn new(color_target: ResourceId) -> Self {
        Self { depth: None, color_target, depth_target: None, velocity: None, fog: None }
    }

    /// With what ends primary rays, if anything does.
    pub fn with_depth(self, depth: impl Into<Option<HostDepth>>) -> Self {
        Self { depth: depth.into(), ..self }
    }

    /// With where the volumes' depth is written, if anywhere.
    pub fn with_depth_target(self, target: impl Into<Option<ResourceId>>) -> Self {
        Self { depth_target: target.into(), ..self }
    }

    /// With where it is written how far the volumes have moved, if anywhere.
    pub fn with_velocity(self, velocity: impl Into<Option<HostVelocity>>) -> Self {
        Self { velocity: velocity.into(), ..self }
    }

    /// With fog, if there is any.
    pub fn with_fog(self, fog: impl Into<Option<Fog>>) -> Self {
        Self { fog: fog.into(), ..self }
    }
}

/// How far a live view is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LiveStatus {
    /// Samples that every pixel has; while light changes a little, what they count, about.
    pub samples: u32,
    /// The part of the image's samples that is traced, 0 to 1: it grows with every row, also while some pixel has none. What
    /// starts over because the host's depth changed does not count against it, so that it is no promise.
    pub progress: f32,
    /// Whether there is nothing more to trace unless something changes, as far as is known. Where dispatches may leave
    /// paths behind, that is known when the film was counted, frames after it was traced.
    pub converged: bool,
    /// Whether a frame's read-back was not handed to [`LiveView::feedback`](super::LiveView::feedback) yet. A host that draws on demand must not
    /// rest before it did that and asked [`LiveView::status`](super::LiveView::status) again: nobody but the GPU knows which pixels started over
    /// because the host's depth changed, and whether all have their samples.
    pub awaits_feedback: bool,
    /// Pixel samples that the last frame traces.
    pub pixel_samples: u64,
    /// Whether it traced less than it might have, for another view of the scene taught the [light](LiveSettings::kept_light) that
    /// they share: its time says little of what samples cost.
    pub awaits_turn: bool,
    /// Pixels that lack samples and will not get them: the driver ended their paths before their time.
    pub lost_pixels: u32,
    /// Bytes of the device's memory that [kept light](LiveSettings::kept_light) takes for this view, with its part of what it shares
    /// with others; 0 where none is kept.
    pub light_bytes: u64,
}

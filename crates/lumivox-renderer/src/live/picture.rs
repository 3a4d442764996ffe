//! What is seen of a live view's films, for each pixel of the host's image, and how it gets over that.

use lumivox_core::Camera;
use lumivox_shaders::{Kernel, layout};

use super::film::{LiveFilm, pixels};
use super::{HostFrame, LiveSettings};
use crate::error::RenderError;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::{SceneCache, check_binding};

/// Bytes of a pixel's colour.
const COLOR_BYTES: u64 = 16;

/// The films that make the picture.
pub(super) enum Films<'a> {
    Fine(&'a LiveFilm),
    /// While the fine one has holes.
    Coarse(&'a LiveFilm),
    /// The coarse one fades out.
    Both {
        fine: &'a LiveFilm,
        coarse: &'a LiveFilm,
    },
}

/// Colour and depth of every pixel. They are made once in a compute pass: to interpolate films in fragment shaders, for
/// colour and again for depth, takes GPUs that draw slowly several times as long.
#[derive(Debug)]
pub(super) struct Picture {
    color: ResourceId,
    depth: ResourceId,
    size: [u32; 2],
}

impl Picture {
    /// # Errors
    /// [`RenderError::BufferTooLarge`] when the device cannot bind so large a picture.
    pub fn check(size: [u32; 2], cache: &SceneCache) -> Result<(), RenderError> {
        let bytes = pixels(size) * COLOR_BYTES;
        check_binding("picture", bytes, cache.limits().max_storage_binding, "Make the image smaller")
    }

    /// For what was [checked](Self::check).
    pub fn new(size: [u32; 2], recording: &mut Recording) -> Self {
        Self {
            color: recording.create_buffer("live picture", pixels(size) * COLOR_BYTES),
            depth: recording.create_buffer("live picture's depth", pixels(size) * 4),
            size,
        }
    }

    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Makes it, and draws it over the host's.
    pub fn record(
        &self,
        films: Films<'_>,
        settings: &LiveSettings,
        host: &HostFrame,
        camera: &Camera,
        cache: &SceneCache,
        recording: &mut Recording,
    ) {
        self.record_making(films, settings, host, camera, cache, recording);
        self.record_drawing(Kernel::CompositeColor, self.color, host.color_target, recording);
        if let Some(target) = host.depth_target.filter(|_| host.depth.is_some()) {
            self.record_drawing(Kernel::CompositeDepth, self.depth, target, recording);
        }
    }

    fn record_making(
        &self,
        films: Films<'_>,
        settings: &LiveSettings,
        host: &HostFrame,
        camera: &Camera,
        cache: &SceneCache,
        recording: &mut Recording,
    ) {
        // Something has to be bound where there is no second one; it is not looked at.
        let (first, second, second_size) = match films {
            Films::Fine(film) | Films::Coarse(film) => (film, film, [0, 0]),
            Films::Both { fine, coarse } => (fine, coarse, coarse.size),
        };
        let [a, b, c, d] = host.depth.map_or([0.0, 1.0, 0.0, 1.0], |h| h.view_depth_from_ndc);
        let mut params = layout::LivePictureParams {
            view_depth_from_ndc: [a, b, c, d].map(|x| x as f32),
            // z of depth = (a z + b) / (c z + d).
            ndc_from_view_depth: [d, -b, -c, a].map(|x| x as f32),
            picture_size: self.size,
            first_size: first.size,
            second_size,
            exposure: (settings.exposure * cache.light_scale()) as f32,
            clear: host.depth.map_or(0.0, |h| h.clear as f32),
            has_host_depth: u32::from(host.depth.is_some()),
            farthest: cache.farthest(camera) as f32,
            denoised: u32::from(settings.denoise),
            coarse_alone: u32::from(matches!(films, Films::Coarse(_))),
            ..Default::default()
        };
        if let Some(fog) = &host.fog {
            fog.write(camera, &mut params);
        }
        let host_depth = host.depth.map_or(cache.environment_resources()[0], |h| h.texture);
        let films = [first.film, second.film, first.shown(), second.shown()];
        let kernel = Kernel::LivePicture;
        let [x, y] = kernel.workgroup_size();
        recording.push(Step::Dispatch {
            kernel,
            uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
            resources: films.into_iter().chain([host_depth, self.color, self.depth]).collect(),
            workgroups: [self.size[0].div_ceil(x), self.size[1].div_ceil(y)],
        });
    }

    fn record_drawing(
        &self,
        kernel: Kernel,
        plane: ResourceId,
        target: ResourceId,
        recording: &mut Recording,
    ) {
        let params = layout::CompositeParams { width: self.size[0], ..Default::default() };
        let uniforms = vec![bytemuck::bytes_of(&params).to_vec()];
        recording.push(Step::Draw { kernel, uniforms, resources: vec![plane], target });
    }

    pub fn free(self, recording: &mut Recording) {
        for id in [self.color, self.depth] {
            recording.push(Step::Free { id });
        }
    }
}

//! What is seen of a live view's films, for each pixel of the host's image.
//!
//! It is made once in a compute pass: to interpolate films in fragment shaders, for colour and again for depth, takes GPUs
//! that draw slowly several times as long.

use lumivox_core::Camera;
use lumivox_shaders::{Kernel, layout};

use super::{FramePass, Use, dispatch};
use crate::live::images::{FilmImages, Image};
use crate::live::{Fog, HostDepth};
use crate::recording::{Recording, ResourceId};

/// A film, and what is shown of it.
#[derive(Clone, Copy, Debug)]
pub struct ShownFilm {
    /// The film.
    pub film: FilmImages,
    /// Where light and alpha are shown from; the film itself where it is not denoised. Those of a coarse film always are.
    pub denoised: Option<Image>,
}

impl ShownFilm {
    fn images(&self) -> impl Iterator<Item = Image> + use<> {
        [self.film.film(), self.film.ray_limits()].into_iter().chain(self.denoised)
    }

    fn shown(&self) -> ResourceId {
        self.denoised.map_or(self.film.buffer, |denoised| denoised.buffer)
    }
}

/// The films that make the picture.
#[derive(Clone, Copy, Debug)]
pub enum PictureFilms {
    /// The fine one alone.
    Fine(ShownFilm),
    /// The coarse one alone, while the fine one has holes.
    Coarse(ShownFilm),
    /// The coarse one fades out.
    Both {
        /// The one that comes.
        fine: ShownFilm,
        /// The one that goes.
        coarse: ShownFilm,
    },
    /// A picture of kept light that fades out.
    Kept {
        /// The film that comes.
        fine: ShownFilm,
        /// The picture that goes: as large as the film.
        light: Image,
        /// Whether the film is shown, too: it has no holes.
        is_whole: bool,
    },
}

/// Makes the picture's colour and depth.
#[derive(Clone, Copy, Debug)]
pub struct PicturePass {
    /// What it is made of.
    pub films: PictureFilms,
    /// Whether the fine film is shown as the denoiser has it.
    pub is_denoised: bool,
    /// Where the films are seen from.
    pub camera: Camera,
    /// View depth of the farthest point of all volumes.
    pub farthest: f64,
    /// What light is multiplied by.
    pub exposure: f64,
    /// The host's depth, if it gives any.
    pub host_depth: Option<HostDepth>,
    /// Any 2D texture: something has to be bound where the host gives no depth.
    pub any_texture: ResourceId,
    /// The host's fog.
    pub fog: Option<Fog>,
    /// What comes out: premultiplied light, and alpha.
    pub color: Image,
    /// And depth in the host's numbers.
    pub depth: Image,
}

impl PicturePass {
    /// The films, and the size of the second one. It is not looked at where that is 0, but has to be bound.
    fn films(&self) -> (ShownFilm, ShownFilm, [u32; 2]) {
        match self.films {
            PictureFilms::Kept { fine, light, .. } => {
                (fine, ShownFilm { film: fine.film, denoised: Some(light) }, light.size)
            }
            PictureFilms::Fine(film) | PictureFilms::Coarse(film) => (film, film, [0, 0]),
            PictureFilms::Both { fine, coarse } => (fine, coarse, coarse.film.size),
        }
    }
}

impl FramePass for PicturePass {
    fn name(&self) -> &'static str {
        "picture"
    }

    fn uses(&self) -> Vec<Use> {
        let (first, second, second_size) = self.films();
        let second = Some(second).filter(|_| second_size != [0, 0]);
        let films = [first].into_iter().chain(second).flat_map(|film| film.images());
        films.map(Use::read).chain([Use::make(self.color), Use::make(self.depth)]).collect()
    }

    fn record(&self, recording: &mut Recording) {
        let (first, second, second_size) = self.films();
        let [a, b, c, d] = self.host_depth.map_or([0.0, 1.0, 0.0, 1.0], |h| h.view_depth_from_ndc);
        let mut params = layout::LivePictureParams {
            view_depth_from_ndc: [a, b, c, d].map(|x| x as f32),
            // z of depth = (a z + b) / (c z + d).
            ndc_from_view_depth: [d, -b, -c, a].map(|x| x as f32),
            picture_size: self.color.size,
            first_size: first.film.size,
            second_size,
            exposure: self.exposure as f32,
            clear: self.host_depth.map_or(0.0, |h| h.clear as f32),
            has_host_depth: u32::from(self.host_depth.is_some()),
            farthest: self.farthest as f32,
            denoised: u32::from(self.is_denoised),
            film_is_shown: match self.films {
                PictureFilms::Kept { is_whole, .. } => u32::from(is_whole),
                _ => 1,
            },
            kept_light: u32::from(matches!(self.films, PictureFilms::Kept { .. })),
            coarse_alone: u32::from(matches!(self.films, PictureFilms::Coarse(_))),
            ..Default::default()
        };
        if let Some(fog) = &self.fog {
            fog.write(&self.camera, &mut params);
        }
        let host_depth = self.host_depth.map_or(self.any_texture, |h| h.texture);
        let resources = vec![
            first.film.buffer,
            second.film.buffer,
            first.shown(),
            second.shown(),
            host_depth,
            self.color.buffer,
            self.depth.buffer,
        ];
        dispatch(Kernel::LivePicture, &params, resources, self.color.size, recording);
    }
}

//! The images of a live view by their names: where each lies, how large it is, and since when it holds something.

use std::ops::Range;

use crate::error::RenderError;
use crate::film;
use crate::recording::{Recording, ResourceId, Step};
use crate::scene_cache::{SceneCache, check_binding};

/// A film of a live view, by how fine it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Grain {
    /// The one that converges.
    Fine,
    /// The one that answers at once, and shows through until the fine one is good enough; or the fine one of the image
    /// before, for as long.
    Coarse,
    /// Half as coarse, and hidden until it is whole.
    Finer,
    /// Of paths that leave points for the light that is kept. It is not shown.
    Points,
}

/// The name of an image of a live view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum LiveImage {
    /// The sums of a film over its samples, in planes as [`Film`](crate::Film) has them: `(radiance, alpha)` and `(view depth,
    /// squared luminance, samples, state of a path that is put aside)`. From the first frame on; a coarse one while it is
    /// shown.
    Film(Grain),
    /// Albedo of the first hits of the fine film's samples, summed up: `(red, green, blue, 0)`. Over alpha's sum, of the first
    /// plane of [`Film`](Self::Film), it is the mean; so is the view depth in its second plane. The bytes of `Film`, `Albedo` and
    /// [`Normal`](Self::Normal), one after the other, are those of a [`Film`](crate::Film) with guides. While
    /// [guides](crate::LiveSettings::guides) are kept.
    Albedo,
    /// Normals of the first hits, in world space, towards the camera; as [`Albedo`](Self::Albedo).
    Normal,
    /// View depth in metres at which a film's primary rays end, 0 where they do not. As long as its film.
    RayLimits(Grain),
    /// What the denoiser made of a film: planes of `(mean light, alpha)` and `(variance of its luminance, ray limit, samples,
    /// view depth)`. While that is what is shown of the film.
    Denoised(Grain),
    /// A picture from the light that is kept: planes of `(light, alpha)` and `(.., ray limit, .., view depth)`, whose other
    /// numbers are for the next one. As long as that is shown.
    KeptLight,
    /// What is drawn over the host's colour: premultiplied light, and alpha. As large as the host's image, from the first
    /// frame on.
    Color,
    /// What is written into the host's depth, in its own numbers; negative where nothing is. As [`Color`](Self::Color).
    Depth,
}

/// How the pixels of an image are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PixelFormat {
    /// A float of 32 bits.
    Float,
    /// Four of them.
    FourFloats,
}

impl PixelFormat {
    /// Bytes of a pixel in one plane.
    pub fn bytes(self) -> u64 {
        match self {
            PixelFormat::Float => 4,
            PixelFormat::FourFloats => 16,
        }
    }
}

/// An image, and where it lies: planes one after the other, rows from the top, without gaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Image {
    /// What it is.
    pub name: LiveImage,
    /// The storage buffer that it is a part of.
    pub buffer: ResourceId,
    /// The byte at which its first pixel begins.
    pub offset: u64,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Planes of so many pixels.
    pub planes: u32,
    /// Of all planes.
    pub format: PixelFormat,
}

impl Image {
    /// Its bytes in the buffer.
    pub fn bytes(&self) -> Range<u64> {
        let bytes = pixels(self.size) * self.format.bytes() * u64::from(self.planes);
        self.offset..self.offset + bytes
    }

    /// Records that it comes back.
    pub fn record_read(&self, recording: &mut Recording) {
        recording.push(Step::ReadBuffer { id: self.buffer, range: self.bytes() });
    }
}

/// The images of one film. They share a buffer, for kernels bind few: its planes, then its ray limits, then its guides, which
/// not all have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FilmImages {
    /// Which film.
    pub grain: Grain,
    /// What they lie in.
    pub buffer: ResourceId,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Whether there are first-hit albedo and normal. Of a live view the fine film alone has them.
    pub guides: bool,
}

impl FilmImages {
    /// Bytes of a buffer that holds those of `pixels`; a multiple of 16.
    pub fn buffer_bytes(pixels: u64, guides: bool) -> u64 {
        guides_begin(pixels) + pixels * (film::bytes_per_pixel(guides) - film::bytes_per_pixel(false))
    }

    /// [`LiveImage::Film`].
    pub fn film(&self) -> Image {
        Image {
            name: LiveImage::Film(self.grain),
            buffer: self.buffer,
            offset: 0,
            size: self.size,
            planes: film::plane_count(false) as u32,
            format: PixelFormat::FourFloats,
        }
    }

    /// [`LiveImage::RayLimits`].
    pub fn ray_limits(&self) -> Image {
        Image {
            name: LiveImage::RayLimits(self.grain),
            offset: self.film().bytes().end,
            planes: 1,
            format: PixelFormat::Float,
            ..self.film()
        }
    }

    /// [`LiveImage::Albedo`] and [`LiveImage::Normal`], if it has them.
    pub fn guides(&self) -> Option<[Image; 2]> {
        let albedo = Image {
            name: LiveImage::Albedo,
            offset: guides_begin(pixels(self.size)),
            planes: 1,
            ..self.film()
        };
        let normal = Image { name: LiveImage::Normal, offset: albedo.bytes().end, ..albedo };
        self.guides.then_some([albedo, normal])
    }

    /// What each sample adds to: the film, and its guides.
    pub fn sums(&self) -> impl Iterator<Item = Image> + use<> {
        [self.film()].into_iter().chain(self.guides().into_iter().flatten())
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = Image> + use<> {
        self.sums().chain([self.ray_limits()])
    }
}

/// The byte at which the guides of a film begin: as `ray_limits_end` of the kernels has it.
fn guides_begin(pixels: u64) -> u64 {
    let limits = (pixels * PixelFormat::Float.bytes()).next_multiple_of(PixelFormat::FourFloats.bytes());
    pixels * film::bytes_per_pixel(false) + limits
}

/// What is seen, for each pixel of the host's image.
#[derive(Clone, Copy, Debug)]
pub(super) struct PictureImages {
    pub color: Image,
    pub depth: Image,
}

impl PictureImages {
    /// # Errors
    /// [`RenderError::BufferTooLarge`] when the device cannot bind so large a picture.
    pub fn check(size: [u32; 2], cache: &SceneCache) -> Result<(), RenderError> {
        let bytes = pixels(size) * PixelFormat::FourFloats.bytes();
        check_binding("picture", bytes, cache.limits().max_storage_binding, "Make the image smaller")
    }

    /// For what was [checked](Self::check).
    pub fn new(size: [u32; 2], recording: &mut Recording) -> Self {
        let mut image = |name, label, format: PixelFormat| {
            let buffer = recording.create_buffer(label, pixels(size) * format.bytes());
            Image { name, buffer, offset: 0, size, planes: 1, format }
        };
        Self {
            color: image(LiveImage::Color, "live picture", PixelFormat::FourFloats),
            depth: image(LiveImage::Depth, "live picture's depth", PixelFormat::Float),
        }
    }

    pub fn size(&self) -> [u32; 2] {
        self.color.size
    }

    pub fn free(self, recording: &mut Recording) {
        for image in [self.color, self.depth] {
            recording.push(Step::Free { id: image.buffer });
        }
    }
}

pub(super) fn pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

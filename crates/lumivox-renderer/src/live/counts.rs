//! What a live view knows of its films from their counts, which come frames later.

use lumivox_shaders::layout;

/// Where the count of a film that should be whole is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CountOfWhole {
    /// One is on its way.
    pub under_way: bool,
    /// So many on their way are of another image, or of films that need not be whole.
    pub outdated: u32,
    /// The last one found nothing missing.
    pub confirmed: bool,
    /// Pixels that will not get what they lack.
    pub lost: u32,
}

impl CountOfWhole {
    /// The film is not what it was.
    pub fn forget(&mut self) {
        let outdated = self.outdated + u32::from(self.under_way);
        *self = Self { outdated, ..Default::default() };
    }
}

/// What becomes of a scene's paths on devices that put some aside. What is known of the scene before holds until a count
/// comes: what moves changes the scene in every frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PathsOfScene {
    pub are_known: bool,
    pub are_of_this_scene: bool,
    /// Some have to go on in another dispatch.
    pub lag: bool,
    /// Some need their invocation alone.
    pub starve: bool,
}

impl PathsOfScene {
    pub fn learn(&mut self, count: &layout::FilmCount) {
        let before = if self.are_of_this_scene { *self } else { Self::default() };
        *self = Self {
            are_known: true,
            are_of_this_scene: true,
            lag: before.lag || count.aside + count.starved > 0,
            starve: before.starve || count.starved > 0,
        };
    }
}

//! Texture formats, by the numbers of Unity's `GraphicsFormat`.

use wgpu::TextureFormat;

/// wgpu's format of the same layout.
pub fn format(number: u32) -> Option<TextureFormat> {
    Some(match number {
        4 => TextureFormat::Rgba8UnormSrgb,
        5 => TextureFormat::R8Unorm,
        6 => TextureFormat::Rg8Unorm,
        8 => TextureFormat::Rgba8Unorm,
        21 => TextureFormat::R16Unorm,
        22 => TextureFormat::Rg16Unorm,
        24 => TextureFormat::Rgba16Unorm,
        37 => TextureFormat::R32Uint,
        45 => TextureFormat::R16Float,
        46 => TextureFormat::Rg16Float,
        48 => TextureFormat::Rgba16Float,
        49 => TextureFormat::R32Float,
        50 => TextureFormat::Rg32Float,
        52 => TextureFormat::Rgba32Float,
        57 => TextureFormat::Bgra8UnormSrgb,
        59 => TextureFormat::Bgra8Unorm,
        74 => TextureFormat::Rg11b10Ufloat,
        93 => TextureFormat::Depth32Float,
        _ => return None,
    })
}

/// Bytes of a texel.
pub fn texel_bytes(format: TextureFormat) -> u32 {
    format.block_copy_size(None).unwrap_or(4)
}

//! Textures in wgpu's words: formats, by the numbers of Unity's `GraphicsFormat`, shapes and boxes.

use wgpu::TextureFormat;

use crate::spirv::Shape;

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

/// What a shader sees of a texture; one level of it, or all.
pub fn view(texture: &wgpu::Texture, shape: Shape, level: Option<u32>) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(match shape {
            Shape::Flat => wgpu::TextureViewDimension::D2,
            Shape::Array => wgpu::TextureViewDimension::D2Array,
            Shape::Cube => wgpu::TextureViewDimension::Cube,
            Shape::Solid => wgpu::TextureViewDimension::D3,
        }),
        aspect: if texture.format().is_depth_stencil_format() {
            wgpu::TextureAspect::DepthOnly
        } else {
            wgpu::TextureAspect::All
        },
        base_mip_level: level.unwrap_or(0),
        mip_level_count: level.map(|_| 1),
        ..Default::default()
    })
}

/// Where a box begins.
pub fn origin([x, y, z]: [u32; 3]) -> wgpu::Origin3d {
    wgpu::Origin3d { x, y, z }
}

/// How large it is.
pub fn extent([width, height, depth]: [u32; 3]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: depth }
}

//! How precisely a device filters channels of 8 bits. Nothing says so: an H200 does to a 65,536th, lavapipe to a 256th.

use lumivox_renderer::FineTexels;

use crate::error::GpuError;
use crate::submission::ReadBack;

/// Points between two texels at which they are filtered.
const POINTS: u32 = 256;

const TEST: &str = "
@group(0) @binding(0) var texels: texture_3d<f32>;
@group(0) @binding(1) var linear: sampler;
@group(0) @binding(2) var<storage, read_write> filtered: array<vec2f>;

@compute @workgroup_size(64)
fn filter_between(@builtin(global_invocation_id) id: vec3u) {
    let along = 0.25 + 0.5 * (f32(id.x) + 0.5) / f32(arrayLength(&filtered));
    filtered[id.x] = textureSampleLevel(texels, linear, vec3f(along, 0.5, 0.5), 0.0).rg;
}
";

/// Two neighbours of 16 bits in two bytes, of which the first differs, too: all that is filtered between them lies between them, whatever
/// the weights are.
const NEIGHBOURS: [u16; 2] = [0x76ff, 0x7700];

/// A device at work on two texels, which tells how it can store [voxels of more than 8 bits](crate::Executor::store_as).
#[derive(Debug)]
pub struct FilterTest(Option<ReadBack>);

impl FilterTest {
    /// Hands it to the device, and does not wait.
    pub fn begin(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let has_norms = device.features().contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM);
        Self((!has_norms).then(|| submit(device, queue)))
    }

    /// What the device does best, as soon as that is known; never waits.
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device is gone.
    pub fn poll(&mut self) -> Option<Result<FineTexels, GpuError>> {
        match &mut self.0 {
            Some(read_back) => Some(read_back.poll()?.map(|bytes| judge(&bytes))),
            None => Some(Ok(FineTexels::Norms)),
        }
    }

    /// Waits for it. Not in browsers: see [`ReadBack::wait`].
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device is gone.
    pub fn wait(self) -> Result<FineTexels, GpuError> {
        self.0.map_or(Ok(FineTexels::Norms), |read_back| Ok(judge(&read_back.wait()?)))
    }
}

/// Both kinds lose something to a filter: half floats have that lost before.
fn judge(filtered: &[u8]) -> FineTexels {
    let [low, high] = NEIGHBOURS.map(f64::from);
    let is_between = |pair: &[u8]| {
        let [first, second] =
            [0, 4].map(|at| f64::from(bytemuck::pod_read_unaligned::<f32>(&pair[at..at + 4])));
        (low - 1.0..=high + 1.0).contains(&(255.0 * (256.0 * first + second)))
    };
    match filtered.chunks_exact(8).all(is_between) {
        true => FineTexels::TwoBytes,
        false => FineTexels::Halves,
    }
}

fn submit(device: &wgpu::Device, queue: &wgpu::Queue) -> ReadBack {
    let size = wgpu::Extent3d { width: 2, height: 1, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("two texels"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::Rg8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4), rows_per_image: Some(1) };
    queue.write_texture(texture.as_image_copy(), &NEIGHBOURS.map(u16::to_be_bytes).concat(), layout, size);
    let bytes = u64::from(POINTS) * 8;
    let buffer = |label, usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes,
            usage,
            mapped_at_creation: false,
        })
    };
    let filtered = buffer("filtered", wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = buffer("read back", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("filter test"),
        source: wgpu::ShaderSource::Wgsl(TEST.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("filter test"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: Default::default(),
        cache: None,
    });
    let linear = device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let view = texture.create_view(&Default::default());
    let resources = [
        wgpu::BindingResource::TextureView(&view),
        wgpu::BindingResource::Sampler(&linear),
        filtered.as_entire_binding(),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("filter test"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(POINTS / 64, 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&filtered, 0, &read, 0, bytes);
    let submission = queue.submit([encoder.finish()]);
    ReadBack::new(device.clone(), read, Some(submission))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filtered(first: impl Fn(f32) -> f32, second: impl Fn(f32) -> f32) -> Vec<u8> {
        let at = (0..POINTS).map(|i| (i as f32 + 0.5) / POINTS as f32);
        at.flat_map(|f| [first(f) / 255.0, second(f) / 255.0]).flat_map(f32::to_le_bytes).collect()
    }

    #[test]
    fn what_is_rounded_to_a_byte_is_not_taken() {
        let [first, second] = [|f: f32| 118.0 + f, |f: f32| 255.0 * (1.0 - f)];
        assert_eq!(judge(&filtered(first, second)), FineTexels::TwoBytes);
        // Of weights of a few bits, both alike.
        let [first, second] =
            [|f: f32| 118.0 + (f * 16.0).floor() / 16.0, |f: f32| 255.0 * (1.0 - (f * 16.0).floor() / 16.0)];
        assert_eq!(judge(&filtered(first, second)), FineTexels::TwoBytes);
        let [first, second] = [|f: f32| (118.0 + f).round(), |f: f32| (255.0 * (1.0 - f)).round()];
        assert_eq!(judge(&filtered(first, second)), FineTexels::Halves);
    }
}

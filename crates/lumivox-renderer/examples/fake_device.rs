//! The smallest executor: replays a render on a device that is not there, and says what a real one is asked for. A port to
//! another GPU API starts from its `execute`: `cargo run --example fake_device`.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use lumivox_core::glam::DAffine3;
use lumivox_core::{Ease, Medium, Modality, Scene, TransferFunction, Volume, Voxels, framing};
use lumivox_renderer::{
    DeviceLimits, FineTexels, Recording, ResourceId, SceneCache, Step, View, ViewSettings, VoxelStore,
};

/// What a GPU would hold.
#[derive(Default)]
struct FakeDevice {
    buffers: HashMap<ResourceId, Vec<u8>>,
    /// Bytes of each texture.
    textures: HashMap<ResourceId, usize>,
    /// Bytes at most at once.
    peak: usize,
    uploaded: usize,
    /// How often each kernel ran.
    dispatches: BTreeMap<&'static str, usize>,
}

impl FakeDevice {
    /// Does what a recording says, in its order, and returns what it reads back.
    fn execute(&mut self, recording: &Recording) -> Vec<Vec<u8>> {
        let mut read_backs = vec![];
        for step in &recording.steps {
            match step {
                Step::CreateBuffer { id, size, .. } => {
                    self.buffers.insert(*id, vec![0; *size as usize]);
                }
                Step::CreateTexture { id, format, size: [x, y, z], .. } => {
                    // A depth of 0 says that it is 2D.
                    let texels = x * y * (*z).max(1);
                    self.textures.insert(*id, texels as usize * format.bytes_per_texel());
                }
                Step::WriteBuffer { id, offset, data } => {
                    let (begin, bytes) = (*offset as usize, data.bytes());
                    self.buffers.get_mut(id).expect("it was made")[begin..begin + bytes.len()]
                        .copy_from_slice(bytes);
                    self.uploaded += bytes.len();
                }
                Step::WriteTexture { data, .. } => self.uploaded += data.bytes().len(),
                Step::CopyTexture { .. } => {}
                Step::ClearBuffer { id } => self.buffers.get_mut(id).expect("it was made").fill(0),
                // A real one makes a pipeline of `kernel.wgsl()` once, binds `uniforms` and `resources` in the order of
                // `kernel.bindings()`, and dispatches or draws.
                Step::Dispatch { kernel, .. } | Step::Draw { kernel, .. } => {
                    *self.dispatches.entry(kernel.entry_point()).or_default() += 1;
                }
                Step::ReadBuffer { id, range } => {
                    read_backs.push(self.buffers[id][range.start as usize..range.end as usize].to_vec());
                }
                Step::Free { id } => {
                    self.buffers.remove(id);
                    self.textures.remove(id);
                }
            }
            let held =
                self.buffers.values().map(Vec::len).sum::<usize>() + self.textures.values().sum::<usize>();
            self.peak = self.peak.max(held);
        }
        read_backs
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let voxels = Voxels::U16((0..64 * 64 * 64).map(|i| (i % 4096) as u16).collect());
    let volume = Volume::new([64; 3], voxels, [1.0, -1024.0], DAffine3::IDENTITY, Modality::Ct)?;
    let look = TransferFunction::from_points(Ease::Linear, &[(0.0, 0.0), (1000.0, 1.0)], &[(0.0, [1.0; 3])])?;
    let scene = Scene::with_volume(Arc::new(volume), Medium::new(look));
    let camera = framing::frame(&scene, 0.5, 0.4, 0.5, 1.0).camera();
    // What any device of WebGPU has; this one has 16-bit norms, too.
    let limits = DeviceLimits::webgpu_default().with(|it| it.fine_texels = FineTexels::Norms);

    let mut device = FakeDevice::default();
    let mut recording = Recording::new();
    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    cache.update(&scene, &mut recording)?;
    let mut view = View::new(ViewSettings::new(256, 256), &cache, &mut recording)?;
    device.execute(&recording);
    let mut submissions = 0;
    loop {
        let mut recording = Recording::new();
        if view.record_samples(&cache, &camera, 64, 1 << 20, &mut recording) == 0 {
            view.record_read_film(&mut recording);
            let film = &device.execute(&recording)[0];
            println!("a film of {} bytes after {submissions} submissions", film.len());
            break;
        }
        device.execute(&recording);
        submissions += 1;
    }
    println!("{} bytes up, {} at once at most", device.uploaded, device.peak);
    for (kernel, times) in &device.dispatches {
        println!("{kernel}: {times} times");
    }
    let mut recording = Recording::new();
    view.free(&mut recording);
    cache.free(&mut recording);
    store.free(&mut recording);
    device.execute(&recording);
    assert!(device.buffers.is_empty() && device.textures.is_empty(), "all that was made is freed");
    Ok(())
}

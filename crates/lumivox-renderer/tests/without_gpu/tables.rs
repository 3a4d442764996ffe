//! One buffer holds transfer functions, where the environment's light comes from, boxes around volumes, and lights.

use std::collections::HashMap;
use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{ClipShape, EnvironmentMap, EnvironmentSource, Light, Scene};
use lumivox_renderer::{Recording, ResourceId, SceneCache, Step, VoxelStore};
use lumivox_shaders::{Kernel, layout};

use crate::scenes::*;

const PAIR_BYTES: usize = 8;

/// What is in buffers of tables by the steps that were recorded.
#[derive(Default)]
struct Device(HashMap<ResourceId, Vec<u8>>);

impl Device {
    fn replay(&mut self, recording: &Recording) {
        for step in &recording.steps {
            match step {
                Step::CreateBuffer { id, label: "tables", size } => {
                    self.0.insert(*id, vec![0; *size as usize]);
                }
                Step::WriteBuffer { id, offset, data } => {
                    if let Some(buffer) = self.0.get_mut(id) {
                        let begin = *offset as usize;
                        buffer[begin..begin + data.bytes().len()].copy_from_slice(data.bytes());
                    }
                }
                Step::Free { id } => {
                    self.0.remove(id);
                }
                _ => {}
            }
        }
    }

    fn tables(&self, cache: &SceneCache) -> &[u8] {
        &self.0[&cache.environment_resources()[1]]
    }
}

fn updated(cache: &mut SceneCache, device: &mut Device, scene: &Scene) -> Recording {
    let mut recording = Recording::new();
    cache.update(scene, &mut recording).unwrap();
    device.replay(&recording);
    recording
}

/// Where nodes and lights begin, and how many lights there are.
fn places(cache: &SceneCache) -> [u32; 3] {
    let mut frame = layout::Frame::default();
    cache.fill_frame(&mut frame);
    [frame.first_node, frame.first_light, frame.light_count]
}

fn sky(size: usize) -> EnvironmentSource {
    let texels = (0..size * size / 2).map(|i| [1.0 + (i % 7) as f32, 1.0, 0.5]).collect();
    EnvironmentSource::Map(Arc::new(EnvironmentMap::new(size, size / 2, texels).unwrap()))
}

fn row(count: usize) -> Scene {
    let mut scene = scene(&vec![volume(8); count]);
    for (i, instance) in scene.volumes.iter_mut().enumerate() {
        instance.world_from_patient = DAffine3::from_translation(DVec3::X * i as f64);
    }
    scene
}

#[test]
fn what_shares_the_buffer_is_there_however_a_scene_has_become_what_it_is() {
    let lights = |count: usize| vec![Light::directional(DVec3::NEG_Y, [1.0; 3]); count];
    let with = |change: &dyn Fn(&mut Scene)| {
        let mut scene = row(2);
        change(&mut scene);
        scene
    };
    let cut = ClipShape::sphere(DVec3::ZERO, 1.0);
    let scenes = [
        row(1),
        with(&|s| s.lights = lights(3)),
        with(&|s| s.lights = lights(20)),
        with(&|s| s.environment.source = sky(64)),
        with(&|s| (s.environment.source, s.lights) = (sky(16), lights(1))),
        Scene { lights: lights(2), ..row(12) },
        with(&|s| (s.volumes[0].clip_shapes, s.lights) = (vec![cut; 3], lights(9))),
        row(1),
    ];
    let store = VoxelStore::new(LIMITS);
    let (mut cache, mut device) = (SceneCache::new(&store), Device::default());
    for (index, scene) in scenes.iter().enumerate() {
        updated(&mut cache, &mut device, scene);
        let again = updated(&mut cache, &mut device, scene);
        assert!(again.is_empty(), "scene {index} is written again: {:?}", again.steps);

        let (mut other, mut others) = (SceneCache::new(&store), Device::default());
        updated(&mut other, &mut others, scene);
        assert_eq!(places(&cache), places(&other), "scene {index}");
        // A row of a few volumes has no boxes.
        let nodes = if scene.volumes.len() < 4 { 0 } else { scene.volumes.len() - 1 };
        let [first_node, first_light, light_count] = places(&cache).map(|n| n as usize);
        let [node, light] = [size_of::<[layout::Child; 2]>(), size_of::<layout::Light>()];
        let lights = first_light * PAIR_BYTES..first_light * PAIR_BYTES + light_count * light;
        for range in [0..first_node * PAIR_BYTES + nodes * node, lights] {
            let (had, fresh) = (&device.tables(&cache)[range.clone()], &others.tables(&other)[range.clone()]);
            assert!(had == fresh, "scene {index}, bytes {range:?}");
        }
    }
}

#[test]
fn lights_that_come_make_no_majorants_anew() {
    let (mut cache, mut device) = (SceneCache::new(&VoxelStore::new(LIMITS)), Device::default());
    let mut scene = row(2);
    updated(&mut cache, &mut device, &scene);
    for count in [1, 8, 9, 2000, 0] {
        scene.lights = vec![Light::directional(DVec3::NEG_Y, [1.0; 3]); count];
        let recording = updated(&mut cache, &mut device, &scene);
        let makes = |step: &Step| {
            matches!(step, Step::Dispatch { kernel: Kernel::MajorantGrid | Kernel::EmptySpace, .. })
        };
        assert!(!recording.steps.iter().any(makes), "{count} lights");
    }
}

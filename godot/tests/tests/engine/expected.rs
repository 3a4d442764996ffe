//! What a case must look like: the renderer's own live view on wgpu, over flat meshes found by geometry.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use lumivox_core::Ray;
use lumivox_core::glam::DVec3;
use lumivox_renderer::live::{Grain, LiveImage};
use lumivox_renderer::{
    Film, HostDepth, HostFrame, LiveSettings, LiveView, Recording, ResourceId, SceneCache, VoxelStore,
};
use lumivox_testing::png_io::SrgbImage;
use lumivox_wgpu::{Gpu, wgpu};

use crate::case::{Case, Light, Mesh, Output};

const NEAR: f64 = 0.001;

/// The picture of a finished view, as a viewport with a linear tone map shows it.
pub fn picture(case: &Case) -> SrgbImage {
    SrgbImage::from_linear(case.size[0] as usize, case.size[1] as usize, &linear(case))
}

/// The same in linear RGB.
pub fn linear(case: &Case) -> Vec<[f64; 3]> {
    let film = film(case);
    let exposure = case.exposure.exp2();
    (0..pixel_count(case))
        .map(|pixel| {
            let behind = host(case, pixel).map_or_else(
                || background(case, pixel),
                |(depth, color)| fogged(case, pixel, depth, color, 1.0),
            );
            let (light, alpha) = (film.radiance(pixel).map(|c| exposure * c), film.alpha(pixel));
            let light = fogged(case, pixel, film.depth(pixel), light, alpha);
            std::array::from_fn(|i| light[i] + (1.0 - alpha) * behind[i])
        })
        .collect()
}

/// Which of some meshes the middle of each pixel shows, where there are no others.
pub fn seen(case: &Case, meshes: &[Mesh]) -> Vec<Option<usize>> {
    let nearest = |pixel| {
        let ray = ray(case, pixel);
        let hits = meshes.iter().enumerate().filter_map(|(i, mesh)| Some((i, intersect(mesh, &ray)?.0)));
        hits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    };
    (0..pixel_count(case)).map(nearest).collect()
}

/// The film of a finished view, made once: several tests look at the same scenes.
pub fn film(case: &Case) -> Arc<Film> {
    static FILMS: Mutex<Option<HashMap<String, Arc<Film>>>> = Mutex::new(None);
    // Without what the film does not depend on.
    let output = Output { msaa: 1, scale: 1.0, scaling: 0, hdr: false, transparent: false, taa: false };
    let traced = Case { name: "", exposure: 0.0, budget: 0.0, kept_light: false, output, ..case.clone() };
    let key = serde_json::to_string(&traced).unwrap();
    let mut films = FILMS.lock().unwrap_or_else(PoisonError::into_inner);
    let films = films.get_or_insert_default();
    films.entry(key).or_insert_with(|| Arc::new(trace(case))).clone()
}

fn trace(case: &Case) -> Film {
    static GPU: OnceLock<Mutex<Gpu>> = OnceLock::new();
    let mut gpu = GPU
        .get_or_init(|| {
            let name = std::env::var("LUMIVOX_GPU").ok();
            Mutex::new(Gpu::open(name.as_deref()).expect("a GPU or software Vulkan"))
        })
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    let [width, height] = case.size;
    let texture = |format, usage| {
        gpu.executor.device().create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    };
    let depth = texture(wgpu::TextureFormat::R32Float, wgpu::TextureUsages::TEXTURE_BINDING);
    let color = texture(wgpu::TextureFormat::Rgba16Float, wgpu::TextureUsages::RENDER_ATTACHMENT);
    let texels: Vec<f32> = (0..pixel_count(case))
        .map(|pixel| host(case, pixel).map_or(0.0, |(depth, _)| (NEAR / depth) as f32))
        .collect();
    gpu.executor.queue().write_texture(
        depth.as_image_copy(),
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * 4),
            rows_per_image: Some(height),
        },
        depth.size(),
    );
    let names = [ResourceId::external(), ResourceId::external()];
    gpu.executor.lend_texture(names[0], &depth);
    gpu.executor.lend_texture(names[1], &color);
    let frame = HostFrame::new(names[1]).with_depth(HostDepth::new(names[0], [0.0, NEAR, 1.0, 0.0], 0.0));
    // Nothing is left of kept light in what is finished: its cells would take their time all the same.
    let settings = LiveSettings::new(width, height).with(|it| {
        it.target_samples = case.samples;
        it.kept_light = false;
    });
    let mut cache = SceneCache::new(&VoxelStore::new(gpu.executor.limits()));
    let mut recording = Recording::new();
    cache.update(&case.scene(), &mut recording).unwrap();
    let mut live = LiveView::new(&settings, &cache, &mut recording).unwrap();
    // Drivers in software put long paths aside: the next frames go on with them.
    loop {
        live.record_frame(&cache, &case.camera(), &settings, &frame, u64::MAX, &mut recording).unwrap();
        for read_back in gpu.executor.execute(&std::mem::take(&mut recording)).unwrap() {
            live.feedback(&read_back.wait().unwrap());
        }
        let status = live.status();
        assert_eq!(status.lost_pixels, 0, "{}: {status:?}", case.name);
        if status.converged {
            break;
        }
    }
    live.record_read(LiveImage::Film(Grain::Fine), &mut recording);
    let bytes = gpu.executor.execute(&recording).unwrap().pop().unwrap().wait().unwrap();
    let mut film = Film::new(width, height, false);
    film.insert([0, 0], [width, height], &bytes);
    let mut recording = Recording::new();
    live.free(&mut recording);
    cache.free(&mut recording);
    gpu.executor.execute(&recording).unwrap();
    film
}

fn pixel_count(case: &Case) -> usize {
    case.size[0] as usize * case.size[1] as usize
}

fn ray(case: &Case, pixel: usize) -> Ray {
    let [width, height] = case.size.map(|n| n as usize);
    let at = [(pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5];
    case.camera().ray([at[0] / width as f64, at[1] / height as f64])
}

/// View depth and colour of the nearest mesh in the middle of a pixel.
fn host(case: &Case, pixel: usize) -> Option<(f64, [f64; 3])> {
    let ray = ray(case, pixel);
    let forward = -case.camera().world_from_camera.matrix3.z_axis;
    let flat = case.meshes.iter().filter_map(|mesh| Some((intersect(mesh, &ray)?.0, mesh.color)));
    let lit = case.lit_meshes.iter().filter_map(|mesh| {
        let (t, normal) = intersect(mesh, &ray)?;
        let point = ray.origin + t * ray.direction;
        let mut color = [0.0; 3];
        for lamp in &case.lamps {
            let reflected = lamp.reflected(point, normal);
            color = std::array::from_fn(|i| color[i] + mesh.color[i] * reflected[i]);
        }
        Some((t, color))
    });
    let (t, color) = flat.chain(lit).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((t * ray.direction.dot(forward), color))
}

/// What is left of light, premultiplied with `alpha`, from a view depth.
fn fogged(case: &Case, pixel: usize, depth: f64, light: [f64; 3], alpha: f64) -> [f64; 3] {
    let Some(fog) = case.fog else { return light };
    let (ray, camera) = (ray(case, pixel), case.camera().world_from_camera);
    let point = ray.origin + depth / ray.direction.dot(-camera.matrix3.z_axis) * ray.direction;
    let fog = fog.core();
    let amount = fog.amount(point.distance(camera.translation), point.y);
    std::array::from_fn(|i| (1.0 - amount) * light[i] + amount * alpha * fog.color[i])
}

/// The slab method: distance and unit normal.
fn intersect(mesh: &Mesh, ray: &Ray) -> Option<(f64, DVec3)> {
    let box_from_world = mesh.place.affine().inverse();
    let origin = box_from_world.transform_point3(ray.origin);
    let direction = box_from_world.transform_vector3(ray.direction);
    let half = DVec3::from_array(mesh.size) / 2.0;
    let (a, b) = ((-half - origin) / direction, (half - origin) / direction);
    let near = a.min(b);
    let (enter, leave) = (near.max_element(), a.max(b).min_element());
    let axis = [DVec3::X, DVec3::Y, DVec3::Z][near.max_position()];
    let normal = box_from_world.matrix3.transpose() * (-axis * direction.dot(axis).signum());
    (enter < leave && enter > 0.0).then(|| (enter, normal.normalize()))
}

fn background(case: &Case, pixel: usize) -> [f64; 3] {
    match &case.light {
        Light::Color(color) => *color,
        Light::Panorama { .. } => case.scene().environment.radiance(ray(case, pixel).direction),
    }
}

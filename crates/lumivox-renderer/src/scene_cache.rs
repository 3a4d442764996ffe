//! A scene on the GPU: what is there already stays, what changed is recorded.

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::medium::SIGMA_UNIT_PER_MM;
use lumivox_core::{
    Environment, EnvironmentSource, ExtinctionSpace, Filter, Medium, Scene, TransferFunction, Volume,
    VolumeInstance,
};
use lumivox_shaders::layout::{Instance, MajorantParams, TABLE_SIZE};
use lumivox_shaders::{Kernel, PathTraceVariant};

use crate::atlas::{Atlas, TexelScale};
use crate::environment::ImportanceGrid;
use crate::error::RenderError;
use crate::majorant_grid::ValueRangeGrid;
use crate::recording::{Payload, Recording, ResourceId, Step, TextureFormat};
use crate::transfer_table::TransferTable;

/// What the host's GPU can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceLimits {
    /// Largest side of a 3D texture.
    pub max_texture_3d: u32,
    /// Largest side of a 2D texture.
    pub max_texture_2d: u32,
    /// Largest storage buffer that can be bound, in bytes.
    pub max_storage_binding: u64,
}

/// How paths find the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightSampling {
    /// Next-event estimation where it pays: for any light but a uniform one.
    #[default]
    Auto,
    /// Always next-event estimation with multiple importance sampling.
    Always,
    /// Never: paths find the light by chance alone.
    Never,
}

/// Value ranges of a volume, shared by its instances.
#[derive(Debug)]
struct CachedVolume {
    volume: Arc<Volume>,
    grid: ValueRangeGrid,
    range_offset: usize,
}

/// The scene's buffers and textures.
#[derive(Debug, Default)]
struct Buffers {
    value_ranges: Option<ResourceId>,
    majorants: Option<ResourceId>,
    opacity_table: Option<ResourceId>,
    color_table: Option<ResourceId>,
    instances: Option<ResourceId>,
    environment_map: Option<ResourceId>,
    importance: Option<ResourceId>,
}

/// What of an instance decides its tables and majorants.
#[derive(Clone, Debug, PartialEq)]
struct TableKey {
    volume: usize,
    transfer_function: TransferFunction,
}

/// A scene on the GPU. [`update`](Self::update) records what differs from the last time.
#[derive(Debug)]
pub struct SceneCache {
    limits: DeviceLimits,
    light_sampling: LightSampling,
    cell_size: Option<usize>,
    atlas: Option<Atlas>,
    volumes: Vec<CachedVolume>,
    wide_filter: bool,
    table_keys: Vec<TableKey>,
    tables: Vec<TransferTable>,
    grid_offsets: Vec<usize>,
    instances: Vec<Instance>,
    source: Option<EnvironmentSource>,
    environment_uniform: bool,
    environment_rotation: f64,
    environment_strength: f64,
    environment_size: [u32; 2],
    importance_size: [u32; 2],
    buffers: Buffers,
    version: u64,
}

impl SceneCache {
    /// An empty cache for a device.
    pub fn new(limits: DeviceLimits) -> Self {
        Self {
            limits,
            light_sampling: LightSampling::Auto,
            cell_size: None,
            atlas: None,
            volumes: vec![],
            wide_filter: false,
            table_keys: vec![],
            tables: vec![],
            grid_offsets: vec![],
            instances: vec![],
            source: None,
            environment_uniform: true,
            environment_rotation: 0.0,
            environment_strength: 1.0,
            environment_size: [1, 1],
            importance_size: [1, 1],
            buffers: Buffers::default(),
            version: 0,
        }
    }

    /// The device's limits.
    pub fn limits(&self) -> DeviceLimits {
        self.limits
    }

    /// Chooses how paths find the light; every choice has the same expectation.
    pub fn set_light_sampling(&mut self, light_sampling: LightSampling) {
        if self.light_sampling != light_sampling {
            self.light_sampling = light_sampling;
            self.version += 1;
        }
    }

    /// Overrides the side of a majorant cell, in voxels; takes effect for volumes loaded from now on.
    pub fn set_cell_size(&mut self, cell_size: Option<usize>) {
        self.cell_size = cell_size.map(|n| n.max(1));
    }

    /// Rises whenever an image of the scene would differ; views start over when it does.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Records what has to be done for the GPU to hold `scene`.
    ///
    /// # Errors
    /// [`RenderError`] when the scene does not fit the device; the cache then holds what it held before, or is empty.
    pub fn update(&mut self, scene: &Scene, recording: &mut Recording) -> Result<(), RenderError> {
        let media: Vec<Medium> = scene.volumes.iter().map(|v| v.medium.clone().sanitized()).collect();
        let places = scene
            .volumes
            .iter()
            .enumerate()
            .map(|(index, instance)| {
                let inverse = instance.world_from_patient.inverse();
                let placed = instance.world_from_patient.is_finite() && inverse.is_finite();
                placed.then_some(inverse).ok_or(RenderError::Placement { index })
            })
            .collect::<Result<Vec<_>, _>>()?;

        let wide_filter = media.iter().any(|m| m.filter == Filter::Tricubic);
        self.update_volumes(scene, wide_filter, recording)?;
        self.update_tables(scene, &media, recording)?;
        self.update_instances(scene, &media, &places, recording);
        self.update_environment(&scene.environment, recording)
    }

    fn update_volumes(
        &mut self,
        scene: &Scene,
        wide_filter: bool,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let mut wanted: Vec<Arc<Volume>> = vec![];
        for instance in &scene.volumes {
            if !wanted.iter().any(|v| Arc::ptr_eq(v, &instance.volume)) {
                wanted.push(instance.volume.clone());
            }
        }
        let same = wanted.len() == self.volumes.len()
            && wanted.iter().zip(&self.volumes).all(|(a, b)| Arc::ptr_eq(a, &b.volume));
        if same && self.atlas.is_some() && (self.wide_filter || !wide_filter) {
            return Ok(());
        }
        if !same || self.atlas.is_none() {
            recording.free(self.atlas.take().map(|a| a.texture));
            self.volumes.clear();
            self.atlas = Some(Atlas::record(&wanted, self.limits.max_texture_3d, recording)?);
        }
        let filter = if wide_filter { Filter::Tricubic } else { Filter::Trilinear };
        let mut range_offset = 0;
        self.volumes = wanted
            .into_iter()
            .map(|volume| {
                let cell_size = self.cell_size.unwrap_or_else(|| ValueRangeGrid::suitable_cell_size(&volume));
                let grid = ValueRangeGrid::new(&volume, filter, cell_size);
                let cached = CachedVolume { volume, range_offset, grid };
                range_offset += cached.grid.ranges.len();
                cached
            })
            .collect();
        self.wide_filter = wide_filter;
        let packed: Vec<u32> = self.volumes.iter().flat_map(|v| v.grid.packed()).collect();
        recording.free(self.buffers.value_ranges.take());
        self.buffers.value_ranges = Some(recording.create_buffer_with("value ranges", &packed));
        // The grids moved: every majorant has to be made anew.
        self.table_keys.clear();
        self.version += 1;
        Ok(())
    }

    fn volume_index(&self, volume: &Arc<Volume>) -> usize {
        self.volumes.iter().position(|v| Arc::ptr_eq(&v.volume, volume)).expect("update_volumes saw it")
    }

    fn update_tables(
        &mut self,
        scene: &Scene,
        media: &[Medium],
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let keys: Vec<TableKey> = scene
            .volumes
            .iter()
            .zip(media)
            .map(|(instance, medium)| TableKey {
                volume: self.volume_index(&instance.volume),
                transfer_function: medium.transfer_function.clone(),
            })
            .collect();
        let volumes: Vec<usize> = keys.iter().map(|k| k.volume).collect();
        let old_volumes: Vec<usize> = self.table_keys.iter().map(|k| k.volume).collect();
        let rebuild = volumes != old_volumes || self.buffers.majorants.is_none();
        if rebuild {
            self.allocate_tables(&volumes, recording)?;
        }
        for (index, key) in keys.iter().enumerate() {
            if rebuild || self.table_keys[index] != *key {
                let volume = &self.volumes[key.volume].volume;
                let table = TransferTable::new(&key.transfer_function, volume);
                self.record_table(index, key.volume, &table, recording);
                if rebuild {
                    self.tables.push(table);
                } else {
                    self.tables[index] = table;
                }
                self.version += 1;
            }
        }
        self.table_keys = keys;
        Ok(())
    }

    /// Makes room for a table and a majorant grid for each instance, whose volumes are given.
    fn allocate_tables(&mut self, volumes: &[usize], recording: &mut Recording) -> Result<(), RenderError> {
        self.tables.clear();
        self.grid_offsets.clear();
        let mut cells = 0;
        for &volume in volumes {
            self.grid_offsets.push(cells);
            cells += self.volumes[volume].grid.ranges.len();
        }
        let check = |what, bytes: u64| {
            let limit = self.limits.max_storage_binding;
            let remedy = "Leave some volumes out";
            if bytes > limit {
                Err(RenderError::BufferTooLarge { what, bytes, limit, remedy })
            } else {
                Ok(())
            }
        };
        let entries = (volumes.len() * TABLE_SIZE) as u64;
        check("majorant grid", cells as u64 * 4)?;
        check("transfer function table", entries * 16)?;
        let buffers = &mut self.buffers;
        for id in [&mut buffers.majorants, &mut buffers.opacity_table, &mut buffers.color_table] {
            recording.free(id.take());
        }
        buffers.majorants = Some(recording.create_buffer("majorants", cells as u64 * 4));
        buffers.opacity_table = Some(recording.create_buffer("opacity table", entries * 8));
        buffers.color_table = Some(recording.create_buffer("color table", entries * 16));
        Ok(())
    }

    /// Uploads an instance's table and has the GPU make its majorants.
    fn record_table(&self, index: usize, volume: usize, table: &TransferTable, recording: &mut Recording) {
        let buffers = &self.buffers;
        let (Some(opacity), Some(color), Some(majorants), Some(ranges)) =
            (buffers.opacity_table, buffers.color_table, buffers.majorants, buffers.value_ranges)
        else {
            unreachable!("allocate_tables and update_volumes made them");
        };
        let first = (index * TABLE_SIZE) as u64;
        let data = Payload::copy_of(&table.opacity_pairs());
        recording.push(Step::WriteBuffer { id: opacity, offset: first * 8, data });
        let data = Payload::copy_of(&table.color);
        recording.push(Step::WriteBuffer { id: color, offset: first * 16, data });

        let cached = &self.volumes[volume];
        let maxima = recording.create_buffer_with("range maxima", &table.range_maxima());
        let (scale, bias) = table.coordinate(TexelScale::of(&cached.volume));
        let cell_count = cached.grid.ranges.len() as u32;
        let [group, _] = Kernel::MajorantGrid.workgroup_size();
        let groups = cell_count.div_ceil(group);
        let workgroups = [groups.min(1024), groups.div_ceil(1024)];
        let params = MajorantParams {
            cell_count,
            range_offset: cached.range_offset as u32,
            majorant_offset: self.grid_offsets[index] as u32,
            row_length: workgroups[0] * group,
            table_scale: scale as f32,
            table_bias: bias as f32,
            padding: [0; 2],
        };
        recording.push(Step::Dispatch {
            kernel: Kernel::MajorantGrid,
            uniforms: vec![bytemuck::bytes_of(&params).to_vec()],
            resources: vec![ranges, maxima, majorants],
            workgroups,
        });
        recording.push(Step::Free { id: maxima });
    }

    fn update_instances(
        &mut self,
        scene: &Scene,
        media: &[Medium],
        patient_from_world: &[DAffine3],
        recording: &mut Recording,
    ) {
        let instances: Vec<Instance> = scene
            .volumes
            .iter()
            .zip(media)
            .zip(patient_from_world)
            .enumerate()
            .map(|(index, ((instance, medium), patient_from_world))| {
                self.instance(index, instance, medium, patient_from_world)
            })
            .collect();
        let bytes = bytemuck::cast_slice::<Instance, u8>(&instances);
        if self.buffers.instances.is_some() && bytes == bytemuck::cast_slice::<Instance, u8>(&self.instances)
        {
            return;
        }
        if instances.len() != self.instances.len() || self.buffers.instances.is_none() {
            recording.free(self.buffers.instances.take());
            let size = size_of::<Instance>() * instances.len().max(1);
            self.buffers.instances = Some(recording.create_buffer("instances", size as u64));
        }
        if let (Some(id), false) = (self.buffers.instances, instances.is_empty()) {
            let data = Payload::copy_of(&instances);
            recording.push(Step::WriteBuffer { id, offset: 0, data });
        }
        self.instances = instances;
        self.version += 1;
    }

    fn instance(
        &self,
        index: usize,
        instance: &VolumeInstance,
        medium: &Medium,
        patient_from_world: &DAffine3,
    ) -> Instance {
        let volume = &*instance.volume;
        let volume_index = self.volume_index(&instance.volume);
        let grid = &self.volumes[volume_index].grid;
        let atlas = self.atlas.as_ref().expect("update_volumes made it");
        let texel = TexelScale::of(volume);
        let (table_scale, table_bias) = self.tables[index].coordinate(texel);
        let dims = DVec3::from_array(volume.dims().map(|n| n as f64));
        // Voxel space on the GPU has voxel centres at i + 0.5.
        let voxel_from_patient =
            DAffine3::from_translation(DVec3::splat(0.5)) * volume.patient_from_voxel().inverse();
        let surface = medium.surface;
        Instance {
            voxel_from_world: affine_rows(voxel_from_patient * *patient_from_world),
            patient_from_world: linear_rows(patient_from_world.matrix3),
            // A gradient is a covector: it maps with the transposed inverse of the points' map.
            patient_gradient_from_voxel: linear_rows(voxel_from_patient.matrix3.transpose()),
            clip_low: (instance.clip_box[0].clamp(DVec3::ZERO, DVec3::ONE) * dims).as_vec3().to_array(),
            density: (medium.density_scale * SIGMA_UNIT_PER_MM) as f32,
            clip_high: (instance.clip_box[1].clamp(DVec3::ZERO, DVec3::ONE) * dims).as_vec3().to_array(),
            albedo: medium.albedo as f32,
            atlas_origin: atlas.origins[volume_index].map(|n| n as f32),
            anisotropy: medium.anisotropy as f32,
            dims: dims.as_vec3().to_array(),
            max_bounces: medium.max_bounces,
            grid_dims: grid.dims.map(|n| n as u32),
            grid_offset: self.grid_offsets[index] as u32,
            cell_size: grid.cell_size as f32,
            cells_per_voxel: 1.0 / grid.cell_size as f32,
            table_scale: table_scale as f32,
            table_bias: table_bias as f32,
            table_offset: (index * TABLE_SIZE) as u32,
            filter_kind: match medium.filter {
                Filter::Nearest => 0,
                Filter::Trilinear => 1,
                Filter::Tricubic => 2,
            },
            value_per_texel: texel.per_texel.abs() as f32,
            world_millimetres: match medium.extinction_space {
                ExtinctionSpace::Volume => 0.0,
                ExtinctionSpace::World => 1000.0,
            },
            surface_strength: surface.strength as f32,
            surface_inverse_gradient: (1.0 / surface.gradient_per_mm) as f32,
            surface_lobe_anisotropy: surface.lobe_anisotropy() as f32,
            surface_specular: surface.specular as f32,
        }
    }

    fn update_environment(
        &mut self,
        environment: &Environment,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let rotation = if environment.rotation.is_finite() { environment.rotation } else { 0.0 };
        let strength = if environment.strength.is_finite() { environment.strength.max(0.0) } else { 1.0 };
        if [rotation, strength] != [self.environment_rotation, self.environment_strength] {
            self.environment_rotation = rotation;
            self.environment_strength = strength;
            self.version += 1;
        }
        if self.source.as_ref() == Some(&environment.source) {
            return Ok(());
        }
        let map = environment.to_map();
        let limit = self.limits.max_texture_2d;
        if map.width.max(map.height) > limit as usize {
            return Err(RenderError::BufferTooLarge {
                what: "environment map",
                bytes: (map.width * map.height * 16) as u64,
                limit: u64::from(limit) * u64::from(limit) * 16,
                remedy: "Scale it down",
            });
        }
        let grid = ImportanceGrid::new(&map);
        recording.free(self.buffers.environment_map.take());
        recording.free(self.buffers.importance.take());
        self.environment_size = [map.width as u32, map.height as u32];
        self.importance_size = grid.size.map(|n| n as u32);
        let [width, height] = self.environment_size;
        let id = recording.create_texture("environment", TextureFormat::Rgba32Float, [width, height, 0]);
        let texels: Vec<[f32; 4]> = map.texels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
        let data = Payload::copy_of(&texels);
        recording.push(Step::WriteTexture { id, origin: [0; 3], size: [width, height, 1], data });
        self.buffers.environment_map = Some(id);
        self.buffers.importance = Some(recording.create_buffer_with("importance", &grid.cells));
        self.environment_uniform = environment.is_uniform();
        self.source = Some(environment.source.clone());
        self.version += 1;
        Ok(())
    }

    /// The path-tracing kernel for what the scene holds.
    pub(crate) fn variant(&self, guides: bool) -> PathTraceVariant {
        PathTraceVariant {
            light_sampling: match self.light_sampling {
                LightSampling::Auto => !self.environment_uniform,
                LightSampling::Always => true,
                LightSampling::Never => false,
            },
            surface: self.instances.iter().any(|i| i.surface_strength > 0.0),
            guides,
            mixed_filters: self.instances.iter().any(|i| i.filter_kind != 1),
        }
    }

    /// The scene's part of a frame's parameters.
    pub(crate) fn fill_frame(&self, frame: &mut lumivox_shaders::layout::Frame) {
        let size = self.atlas.as_ref().map_or([1; 3], |a| a.size);
        frame.volume_count = self.instances.len() as u32;
        frame.inverse_atlas_size = size.map(|n| 1.0 / n as f32);
        frame.environment_strength = self.environment_strength as f32;
        let (sin, cos) = self.environment_rotation.sin_cos();
        frame.environment_rotation = [cos as f32, sin as f32];
        frame.environment_size = self.environment_size;
        frame.importance_size = self.importance_size;
    }

    /// The scene's resources in the order of the path-tracing kernel, up to the film.
    pub(crate) fn path_trace_resources(&self) -> Vec<ResourceId> {
        let b = &self.buffers;
        let atlas = self.atlas.as_ref().map(|a| a.texture);
        [b.instances, b.opacity_table, b.color_table, b.majorants, atlas, b.environment_map, b.importance]
            .map(|id| id.expect("update() comes before tracing"))
            .to_vec()
    }

    /// The environment's texture.
    pub(crate) fn environment_map(&self) -> ResourceId {
        self.buffers.environment_map.expect("update() comes before display")
    }

    /// The environment's importance grid.
    pub fn importance_resources(&self) -> [ResourceId; 2] {
        [self.environment_map(), self.buffers.importance.expect("update() comes before sampling")]
    }

    /// The buffer of majorants, its cells in the order of the scene's volumes, and their number.
    pub fn majorants(&self) -> (ResourceId, usize) {
        let cells = self.table_keys.iter().map(|k| self.volumes[k.volume].grid.ranges.len()).sum();
        (self.buffers.majorants.expect("update() comes before reading"), cells)
    }

    /// Records that everything is freed.
    pub fn free(mut self, recording: &mut Recording) {
        recording.free(self.atlas.take().map(|a| a.texture));
        let b = self.buffers;
        for id in [
            b.value_ranges,
            b.majorants,
            b.opacity_table,
            b.color_table,
            b.instances,
            b.environment_map,
            b.importance,
        ] {
            recording.free(id);
        }
    }
}

fn affine_rows(m: DAffine3) -> [[f32; 4]; 3] {
    let linear = m.matrix3.transpose();
    let row = |r: DVec3, w: f64| [r.x as f32, r.y as f32, r.z as f32, w as f32];
    [
        row(linear.x_axis, m.translation.x),
        row(linear.y_axis, m.translation.y),
        row(linear.z_axis, m.translation.z),
    ]
}

fn linear_rows(m: DMat3) -> [[f32; 4]; 3] {
    affine_rows(DAffine3::from_mat3(m))
}

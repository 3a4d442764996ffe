//! A scene on the GPU: what is there already stays, what changed is recorded.
//!
//! The device's [`VoxelStore`] holds the voxels and their value ranges, [`tables`] the transfer functions and what else
//! points are classified by ([`classes`], [`label_sets`]), [`majorants`] makes majorants of both, [`fields`] are volumes that
//! say what other volumes' points are, [`environment`] the light from all around, [`lights`] the engine's lights, [`hierarchy`] makes the boxes by which
//! rays find volumes; the instances that tie them together are here. [`preparation`] computes ahead, on another thread,
//! what takes long.

mod cell_size;
mod changing_light;
mod classes;
mod environment;
mod fields;
mod hierarchy;
mod importance;
mod label_sets;
mod lights;
mod majorants;
mod mirror;
mod numbers;
mod preparation;
mod tables;
mod transfer_table;
mod wanted;

use std::sync::Arc;

use lumivox_core::glam::{DAffine3, DMat3, DVec3};
use lumivox_core::medium::SIGMA_UNIT_PER_MM;
use lumivox_core::{ExtinctionSpace, Filter, Medium, Scene, Volume, VolumeInstance};
use lumivox_shaders::layout::{Frame, Instance, Light};
use lumivox_shaders::{Classes, Kernel, PathTraceVariant, constants};

pub use self::cell_size::CellSize;
use self::changing_light::MeanLight;
pub(crate) use self::changing_light::{LightPast, change_of_color, kept_after};
use self::classes::Looks;
use self::environment::{CachedEnvironment, NewMap};
use self::fields::Field;
pub(crate) use self::hierarchy::MANY as MANY_VOLUMES;
use self::hierarchy::{Bounds, Node};
pub(crate) use self::lights::effective as effective_lights;
use self::mirror::{Mirror, Part};
pub(crate) use self::numbers::Numbered;
use self::numbers::{Numbers, Shape};
pub use self::preparation::Preparation;
use self::tables::{Besides, CachedTables, TableOf};
use crate::error::RenderError;
use crate::features::{Features, ViewKind};
use crate::ids;
use crate::limits::DeviceLimits;
use crate::live::CellsOfScene;
use crate::recording::{Recording, ResourceId};
use crate::store::{SceneCopy, Source, TexelScale, VoxelStore};

/// How paths find the environment's light. The engine's lights, which no path could find, are always sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum EnvironmentSampling {
    /// Next-event estimation where it pays: for any light but a uniform one.
    #[default]
    Auto,
    /// Always next-event estimation with multiple importance sampling.
    Always,
    /// Never: paths find the light by chance alone.
    Never,
}

/// An instance that can be seen, with everything in its documented range.
pub(crate) struct Placed<'a> {
    instance: &'a VolumeInstance,
    pub medium: Medium,
    looks: Looks,
    patient_from_world: DAffine3,
}

impl Placed<'_> {
    /// What it reads of its volume.
    fn source(&self) -> Source {
        Source::new(&self.instance.volume, self.medium.filter)
    }

    /// What its medium depends on besides its values.
    pub fn classes(&self) -> Classes {
        classes::classes_of(self.instance, &self.medium, &self.looks)
    }

    /// Whether light is reflected somewhere in it.
    pub fn reflects(&self) -> bool {
        self.looks.reflect()
    }
}

/// A scene on the GPU. [`update`](Self::update) records what differs from the last time. One that is dropped without
/// [`free`](Self::free) leaves its buffers to the executor until that goes.
#[derive(Debug)]
pub struct SceneCache {
    store: VoxelStore,
    limits: DeviceLimits,
    environment_sampling: EnvironmentSampling,
    cell_size: CellSize,
    /// What there is of each distinct volume, as its filters read it.
    volumes: Vec<(Source, SceneCopy)>,
    /// Whether there are others of which nothing is there yet.
    lacks_volumes: bool,
    tables: CachedTables,
    environment: CachedEnvironment,
    /// Those that shine on something.
    lights: Part<Light>,
    follows_light: bool,
    light_scale: f64,
    light_past: LightPast,
    mean_light: MeanLight,
    /// Volumes that rays meet, then the fields that those read.
    instances: Mirror<Instance>,
    /// How many of them rays meet.
    traced: usize,
    /// The hierarchy over many volumes.
    nodes: Part<Node>,
    /// All that rays meet.
    around: Bounds,
    features: Features,
    unprepared: u64,
    /// By which light that is kept in volumes knows them.
    numbers: Numbers,
    kept_cells: CellsOfScene,
    /// Subtracted from world positions before they are rounded to 32 bits: scenes far from the world's origin keep
    /// their precision.
    origin: DVec3,
    version: u64,
}

impl SceneCache {
    /// An empty cache for a scene whose voxels are in a device's store.
    pub fn new(store: &VoxelStore) -> Self {
        Self {
            store: store.clone(),
            limits: store.limits(),
            environment_sampling: EnvironmentSampling::Auto,
            cell_size: CellSize::default(),
            volumes: vec![],
            lacks_volumes: false,
            tables: CachedTables::default(),
            environment: CachedEnvironment::default(),
            lights: Part::default(),
            follows_light: false,
            light_scale: 1.0,
            light_past: LightPast::default(),
            mean_light: MeanLight::default(),
            instances: Mirror::default(),
            traced: 0,
            nodes: Part::default(),
            around: Bounds::NOTHING,
            features: Features::default(),
            unprepared: 0,
            numbers: Numbers::default(),
            kept_cells: CellsOfScene::default(),
            origin: DVec3::ZERO,
            version: ids::next().0,
        }
    }

    /// The device's limits.
    pub fn limits(&self) -> DeviceLimits {
        self.limits
    }

    /// Chooses how paths find the light; every choice has the same expectation.
    pub fn set_environment_sampling(&mut self, environment_sampling: EnvironmentSampling) {
        if self.environment_sampling != environment_sampling {
            self.environment_sampling = environment_sampling;
            self.version = ids::next().0;
        }
    }

    /// Chooses the side of majorant cells, from the next update on.
    pub fn set_cell_size(&mut self, cell_size: CellSize) {
        self.cell_size = cell_size;
    }

    /// Changes whenever an image of the scene would; unique among caches, too. Views start over when it does.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Records what has to be done for the GPU to hold `scene`, at once. Volumes that are flattened to nothing, or placed
    /// by a transform that is not finite, are not there; those that the GPU has no room for are
    /// [reduced](VoxelStore::resolution).
    ///
    /// # Errors
    /// [`RenderError`] when the scene does not fit the device; then nothing is recorded or changed. But where its volumes do
    /// not, however coarse or with however large cells: that room was made is recorded, and the cache is good for nothing
    /// but another update.
    pub fn update(&mut self, scene: &Scene, recording: &mut Recording) -> Result<(), RenderError> {
        self.update_within(scene, &mut { u64::MAX }, recording)
    }

    /// The same, but brings no more than about `budget` bytes of voxels, which it takes from the budget. A large volume
    /// appears coarse then, and arrives with further updates until the cache [is settled](Self::is_settled); many appear
    /// one after the other.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn update_within(
        &mut self,
        scene: &Scene,
        budget: &mut u64,
        recording: &mut Recording,
    ) -> Result<(), RenderError> {
        let placed = place(scene);
        let (mut wanted, uses) = wanted::distinct(&placed, self.cell_size);
        wanted::widen(&mut wanted, &uses, tables::most_cells(&self.limits));
        let features = Features::of_placed(scene, &placed, false);
        environment::check(&scene.environment, &self.limits)?;
        let lights = lights::effective(&scene.lights, &placed);
        let limit = self.limits.max_storage_binding;
        lights::check(&lights, limit)?;
        let new_map = self.environment.new_map(&scene.environment.source, &mut self.unprepared);
        let besides = |volumes| Besides {
            importance: new_map.as_ref().map_or(self.environment.importance.list.len(), NewMap::cells),
            nodes: hierarchy::node_count(volumes),
            lights: lights.len(),
        };
        tables::check(&placed, features.classes.any(), &besides(placed.len()), limit)?;

        // What is gone makes room for what comes.
        let is_wanted = |(source, _): &(Source, _)| wanted.iter().any(|(other, _)| source == other);
        let (stays, gone): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.volumes).into_iter().partition(is_wanted);
        self.volumes = stays;
        let_go(gone.into_iter().map(|(source, _)| source.volume));
        let acquired = self.store.acquire(&wanted, budget, recording)?;
        self.lacks_volumes = acquired.iter().any(Option::is_none);
        let there = wanted.into_iter().zip(acquired);
        self.volumes = there.filter_map(|((source, _), acquired)| Some((source, acquired?))).collect();
        // Kernels are those of the whole scene from the beginning.
        let features = Features::of_placed(scene, &placed, !lights.is_empty());
        // Without labels and clip shapes nothing is written: what they were is no longer read.
        let features_changed = std::mem::replace(&mut self.features, features) != features;
        // With all that it reads: what labels hide is not to be seen before they come.
        let is_there = |placed: &Placed<'_>| {
            let fields = Field::sources(placed).map(|(_, source)| source);
            let mut wanted = fields.chain([placed.source()]);
            wanted.all(|wanted| self.volumes.iter().any(|(source, _)| *source == wanted))
        };
        let placed: Vec<Placed<'_>> = placed.into_iter().filter(is_there).collect();
        let fields = Field::all(&placed);
        let classified = self.features.classes.any();
        tables::check_cells(&placed, &fields, &self.volumes, &self.limits)?;
        let besides = besides(placed.len());
        let tables_changed =
            self.tables.update(&placed, &fields, classified, &self.volumes, &besides, recording);
        if let Some((buffer, behind)) = self.tables.behind() {
            let [nodes, lights] = besides.offsets(behind);
            self.environment.importance.put(buffer, 0, besides.importance, recording);
            self.nodes.put(buffer, nodes, besides.nodes, recording);
            self.lights.put(buffer, lights, besides.lights, recording);
        }
        let instances_changed = self.update_instances(&placed, &fields, recording);
        let light_changed = self.update_light(&scene.environment, new_map, &lights, recording);
        if features_changed || tables_changed || instances_changed || light_changed {
            self.version = ids::next().0;
        }
        Ok(())
    }

    /// Whether another update with the same scene would find nothing to do: no volume is under way, or could be finer.
    /// False before the first.
    pub fn is_settled(&self) -> bool {
        self.tables.buffers.is_some()
            && !self.lacks_volumes
            && self.volumes.iter().all(|(source, acquired)| self.store.is_settled(source, &acquired.bricks))
    }

    /// Whether all that it shows is still there. What the device [refused](VoxelStore::refused) of another scene may have taken
    /// voxels along that both showed: nothing can be drawn of it until it is made anew.
    pub fn is_intact(&self) -> bool {
        self.volumes.iter().all(|(_, acquired)| !acquired.bricks.is_lost())
    }

    /// The device's voxels.
    pub fn store(&self) -> &VoxelStore {
        &self.store
    }

    fn acquired(&self, source: &Source) -> &SceneCopy {
        acquired(&self.volumes, source)
    }

    fn update_instances(
        &mut self,
        placed: &[Placed<'_>],
        fields: &[Field],
        recording: &mut Recording,
    ) -> bool {
        let origin = middle(
            placed.iter().map(|p| p.instance.world_from_box().transform_point3(DVec3::splat(0.5))).collect(),
        );
        let shape = |p: &Placed<'_>| {
            let dims = self.acquired(&p.source()).bricks.grid.dims;
            Shape::new(&p.instance.volume, dims, p.instance.world_from_patient)
        };
        let shapes = placed.iter().map(shape).collect();
        self.numbers.update(shapes);
        let read =
            Field::twins(fields, placed, |source| self.acquired(source), |i| self.tables.field_grid(i));
        let traced = placed.iter().enumerate().map(|(i, p)| {
            let labels = Field::labels_of(i, fields, &read, placed.len());
            self.instance(i, p, labels, origin)
        });
        let instances = traced.chain(read.iter().copied()).collect();
        self.traced = placed.len();
        let bounds: Vec<Bounds> = placed.iter().map(|p| Bounds::of(p.instance, origin)).collect();
        self.around = Bounds::around(bounds.iter().copied());
        let instances_changed = self.instances.update("instances", instances, recording);
        let nodes = if self.features.has_hierarchy(self.limits) { hierarchy::build(&bounds) } else { vec![] };
        let nodes_changed = self.nodes.update(nodes.into(), recording);
        let moved = std::mem::replace(&mut self.origin, origin) != origin;
        instances_changed | nodes_changed | moved
    }

    /// `labels` is what kernels are told of its field of labels.
    fn instance(&self, index: usize, placed: &Placed<'_>, labels: u32, origin: DVec3) -> Instance {
        let Placed { instance, medium, looks, patient_from_world } = placed;
        let volume = &*instance.volume;
        let SceneCopy { bricks, ranges } = self.acquired(&placed.source());
        let texel = TexelScale::of(volume);
        let TableOf { coordinate: (table_scale, table_bias), table_offset, classes, grid_offset } =
            self.tables.get(index, texel);
        // A reduced copy's voxels are larger; they begin where the volume does.
        let factor = f64::from(bricks.factor);
        let dims = DVec3::from_array(volume.dims().map(|n| n as f64)) / factor;
        let clip_low = instance.clip_box[0].clamp(DVec3::ZERO, DVec3::ONE) * dims;
        let clip_high = (instance.clip_box[1].clamp(DVec3::ZERO, DVec3::ONE) * dims).max(clip_low);
        let voxel_from_patient = voxel_from_patient(volume, bricks.factor);
        let voxel_from_world = voxel_from_patient * *patient_from_world * DAffine3::from_translation(origin);
        let surface = medium.surface;
        Instance {
            voxel_from_world: affine_rows(voxel_from_world),
            patient_from_world: linear_rows(patient_from_world.matrix3),
            // A gradient is a covector: it maps with the transposed inverse of the points' map.
            patient_gradient_from_voxel: linear_rows(voxel_from_patient.matrix3.transpose()),
            clip_low: clip_low.as_vec3().to_array(),
            density: (looks.density * SIGMA_UNIT_PER_MM) as f32,
            clip_high: clip_high.as_vec3().to_array(),
            albedo: medium.albedo as f32,
            bricks: bricks.grid.counts,
            anisotropy: medium.anisotropy as f32,
            dims: bricks.grid.dims.map(|n| n as f32),
            max_bounces: medium.max_bounces,
            grid_dims: ranges.grid_dims,
            grid_offset: grid_offset as u32,
            cell_size: ranges.cell_size as f32,
            cells_per_voxel: 1.0 / ranges.cell_size as f32,
            table_scale: table_scale as f32,
            table_bias: table_bias as f32,
            table_offset: table_offset as u32,
            filter_kind: match medium.filter {
                Filter::Nearest => constants::FILTER_NEAREST,
                // What is smooth about it is in the voxels.
                Filter::Trilinear | Filter::Smooth => constants::FILTER_TRILINEAR,
                Filter::Tricubic => constants::FILTER_TRICUBIC,
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
            layers: instance.layers,
            cells_per_brick: constants::BRICK_SIZE / ranges.cell_size,
            classes: classes as u32,
            full_looks: looks.full_in_cells() as u32,
            surface_metallic: surface.metallic as f32,
            light_number: self.numbers.of(index),
            takes_shares: u32::from(placed.classes().shares),
            labels,
        }
    }

    /// The kernels with which views of `scene` are recorded once [`update`](Self::update) has come to it.
    pub fn kernels(&self, scene: &Scene, view: ViewKind) -> Vec<Kernel> {
        self.sampled(Features::of(scene)).kernels(view, self.limits)
    }

    /// How often [`update`](Self::update) itself had to compute something that takes long, for nobody had before:
    /// a coarse copy of a volume, where an environment's light comes from. See [`preparation`](Self::preparation).
    pub fn unprepared(&self) -> u64 {
        self.unprepared + self.tables.unprepared + self.store.unprepared()
    }

    /// The path-tracing kernel for what the scene holds.
    pub(crate) fn variant(&self, guides: bool, live: bool) -> PathTraceVariant {
        self.sampled(self.features).variant(guides, live, self.limits)
    }

    fn sampled(&self, features: Features) -> Features {
        let environment = match self.environment_sampling {
            EnvironmentSampling::Auto => features.environment,
            EnvironmentSampling::Always => true,
            EnvironmentSampling::Never => false,
        };
        Features { environment, ..features }
    }

    /// The point of the world that is the GPU's origin.
    pub(crate) fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The numbers by which light that is kept in volumes knows those that rays meet; `None` where there are too many of them, or
    /// the device has no kernels for what they are like.
    pub(crate) fn numbers(&self) -> Option<&[Numbered]> {
        self.numbers.list().filter(|_| self.features.can_keep_light(self.limits))
    }

    /// Where in the world they are.
    pub(crate) fn places(&self) -> Vec<(Numbered, DAffine3)> {
        self.numbers.places().collect()
    }

    /// By which part a phase function changes at most for each radian by which it is looked at otherwise: Henyey-Greenstein's has
    /// its largest slope, by its value, at a cosine of `2 g / (1 + g^2)`.
    pub(crate) fn steepest_phase(&self) -> f64 {
        let slope = |instance: &Instance| {
            let g = f64::from(instance.anisotropy.abs());
            3.0 * g / (1.0 - g * g)
        };
        self.instances.list.iter().take(self.traced).map(slope).fold(0.0, f64::max)
    }

    /// Whether something in it has surfaces.
    pub(crate) fn reflects(&self) -> bool {
        self.features.surface
    }

    /// The cells in which live views keep its light.
    pub(crate) fn kept_cells(&self) -> &CellsOfScene {
        &self.kept_cells
    }

    /// Bytes of the voxels of all volumes that rays meet, 16 bits each, empty ones included.
    pub(crate) fn voxel_bytes(&self) -> u64 {
        2 * self.numbers.voxels()
    }

    /// Fills in the scene's part of a frame's parameters.
    pub fn fill_frame(&self, frame: &mut Frame) {
        frame.volume_count = self.traced as u32;
        frame.inverse_pool_sizes = self.store.inverse_pool_sizes();
        frame.environment_strength = self.environment.strength as f32;
        let (sin, cos) = self.environment.rotation.sin_cos();
        frame.environment_rotation = [cos as f32, sin as f32];
        frame.environment_size = self.environment.map_size;
        frame.importance_size = self.environment.importance_size;
        frame.first_node = (self.nodes.offset() / tables::PAIR_BYTES) as u32;
        frame.first_light = (self.lights.offset() / tables::PAIR_BYTES) as u32;
        frame.light_count = self.lights.list.len() as u32;
    }

    /// The textures with the voxels, which the path-tracing kernel binds last.
    pub(crate) fn pools(&self) -> Vec<ResourceId> {
        self.store.pool_textures()
    }

    /// The scene's resources in the order of the path-tracing kernel, up to the film.
    pub(crate) fn path_trace_resources(&self) -> Vec<ResourceId> {
        let tables = self.tables.buffers;
        [self.instances.buffer, tables.map(|b| b.tables), tables.map(|b| b.grids), self.environment.map]
            .map(|id| id.expect("update() comes before tracing"))
            .to_vec()
    }

    /// What media are made of, as kernels bind it that trace no light.
    pub(crate) fn media_resources(&self) -> Vec<ResourceId> {
        let mut resources = self.path_trace_resources();
        resources.pop();
        resources
    }

    /// The environment's map, and the buffer that begins with its importance grid.
    ///
    /// # Panics
    /// Before the first [`update`](Self::update).
    pub fn environment_resources(&self) -> [ResourceId; 2] {
        [self.environment.map, self.tables.buffers.map(|b| b.tables)]
            .map(|id| id.expect("update() comes before display"))
    }

    /// The buffer of majorants, cells of the scene's volumes one after the other, each beside its page, and their number.
    ///
    /// # Panics
    /// Before the first [`update`](Self::update).
    pub fn majorants(&self) -> (ResourceId, usize) {
        let cells = self
            .instances
            .list
            .iter()
            .take(self.traced)
            .map(|i| i.grid_dims.map(|n| n as usize).iter().product::<usize>())
            .sum();
        (self.tables.buffers.expect("update() comes before reading").grids, cells)
    }

    /// Records that everything is freed but the voxels: they are the store's, which [collects](VoxelStore::collect) those
    /// that nobody holds.
    pub fn free(mut self, recording: &mut Recording) {
        self.tables.free(recording);
        self.environment.free(recording);
        self.instances.free(recording);
    }
}

/// Drops volumes, and those that nobody else holds on another thread: to give back the memory of a large one takes longer
/// than a frame may be late.
fn let_go(volumes: impl Iterator<Item = Arc<Volume>>) {
    let last: Vec<Volume> = volumes.filter_map(Arc::into_inner).collect();
    if !last.is_empty() {
        lumivox_core::host::aside(move || drop(last));
    }
}

fn acquired<'a>(volumes: &'a [(Source, SceneCopy)], wanted: &Source) -> &'a SceneCopy {
    let found = volumes.iter().find(|(source, _)| source == wanted);
    &found.expect("every placed volume was acquired").1
}

/// The map to a copy's voxel space on the GPU, where a voxel's centre is at i + 0.5. A reduced copy's voxels are larger; they
/// begin where the volume does.
fn voxel_from_patient(volume: &Volume, factor: u32) -> DAffine3 {
    DAffine3::from_scale(DVec3::splat(1.0 / f64::from(factor)))
        * DAffine3::from_translation(DVec3::splat(0.5))
        * volume.patient_from_voxel().inverse()
}

/// The instances that can be seen.
pub(crate) fn place(scene: &Scene) -> Vec<Placed<'_>> {
    scene
        .volumes
        .iter()
        .filter(|instance| is_finite_on_gpu(instance.world_from_patient))
        .map(|instance| {
            let mut medium = instance.medium.clone().sanitized();
            medium.density_scale = medium.density_scale_in(&instance.volume);
            let looks = Looks::new(instance, &medium);
            let patient_from_world = instance.world_from_patient.inverse();
            Placed { instance, medium, looks, patient_from_world }
        })
        .filter(|placed| is_finite_on_gpu(placed.patient_from_world))
        .collect()
}

/// Whether a map stays finite in 32 bits, the lengths of its columns too.
fn is_finite_on_gpu(map: DAffine3) -> bool {
    const MOST: f64 = 1e18;
    map.is_finite() && map.to_cols_array().iter().all(|x| x.abs() < MOST)
}

/// An error where a buffer is larger than the device binds.
pub(crate) fn check_binding(
    what: &'static str,
    bytes: u64,
    limit: u64,
    remedy: &'static str,
) -> Result<(), RenderError> {
    if bytes > limit { Err(RenderError::BufferTooLarge { what, bytes, limit, remedy }) } else { Ok(()) }
}

/// The median of points along each axis: one that is far from the others leaves it among them, as a mean would not. Of two
/// in the middle, the one nearer to zero.
fn middle(points: Vec<DVec3>) -> DVec3 {
    let along = |axis: usize| {
        let mut sorted: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        sorted.sort_by(f64::total_cmp);
        let (Some(low), Some(high)) =
            (sorted.get(points.len().saturating_sub(1) / 2), sorted.get(points.len() / 2))
        else {
            return 0.0;
        };
        if low.abs() <= high.abs() { *low } else { *high }
    };
    DVec3::new(along(0), along(1), along(2))
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

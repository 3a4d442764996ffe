//! The Rust twins have the layout that the shaders see, and the bindings are declared as the shaders use them.

use std::collections::HashMap;
use std::mem::{offset_of, size_of};

use lumivox_shaders::{BindingKind, Kernel, KernelKind, layout::*};

/// None beyond WebGPU's baseline: half floats packed in words are of it, and lacking in WebGL alone.
const CAPABILITIES: naga::valid::Capabilities = naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32;

fn module(kernel: Kernel) -> naga::Module {
    naga::front::wgsl::parse_str(&kernel.wgsl())
        .unwrap_or_else(|e| panic!("{kernel:?}: {}", e.emit_to_string(&kernel.wgsl())))
}

/// Offsets of a WGSL struct's members, and its size.
fn layout_in(kernel: Kernel, name: &str) -> (HashMap<String, u32>, u32) {
    let module = module(kernel);
    let (_, ty) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).expect(name);
    let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is no struct") };
    (members.iter().map(|m| (m.name.clone().unwrap(), m.offset)).collect(), *span)
}

macro_rules! assert_twin {
    ($kernel:expr, $type:ident { $($field:ident),* $(,)? }) => {
        let (offsets, size) = layout_in($kernel, stringify!($type));
        let twin: HashMap<String, u32> =
            [$((stringify!($field).to_owned(), offset_of!($type, $field) as u32)),*].into();
        assert_eq!(twin, offsets, "members of {}", stringify!($type));
        assert_eq!(size_of::<$type>() as u32, size, "size of {}", stringify!($type));
    };
}

#[test]
fn twins_have_the_shaders_layout() {
    let path_trace = Kernel::PathTrace(Default::default());
    assert_twin!(
        path_trace,
        Frame {
            camera_position,
            seed,
            camera_right,
            volume_count,
            camera_up,
            samples,
            camera_forward,
            sample_limit,
            image_size,
            film_origin,
            film_size,
            row_begin,
            row_end,
            environment_strength,
            light_count,
            environment_rotation,
            environment_size,
            importance_size,
            roulette_start,
            orthographic,
            turn_limit,
            lone_invocation,
            view_axis,
            group_stride,
            ambient,
            sharers,
            only_below,
            first_node,
            first_light,
            point_share,
            pixel_size,
            light_slots,
            light_scale,
            point_rays,
            march_first,
            march_stride,
            padding,
            inverse_pool_sizes,
        }
    );
    assert_twin!(path_trace, ImportanceCell { threshold, alias_index, density, alias_density });
    assert_twin!(path_trace, Child { low, index, high, padding });
    assert_twin!(
        path_trace,
        Instance {
            voxel_from_world,
            patient_from_world,
            patient_gradient_from_voxel,
            clip_low,
            density,
            clip_high,
            albedo,
            bricks,
            anisotropy,
            dims,
            max_bounces,
            grid_dims,
            grid_offset,
            cell_size,
            cells_per_voxel,
            table_scale,
            table_bias,
            table_offset,
            filter_kind,
            value_per_texel,
            world_millimetres,
            surface_strength,
            surface_inverse_gradient,
            surface_lobe_anisotropy,
            surface_specular,
            layers,
            cells_per_brick,
            classes,
            full_looks,
            surface_metallic,
            light_number,
            takes_shares,
            labels,
        }
    );
    assert_twin!(
        path_trace,
        Light {
            position,
            kind,
            color,
            size,
            axis,
            layers,
            inverse_range,
            decay,
            inverse_cone,
            cone_attenuation,
        }
    );
    assert_twin!(
        Kernel::ValueRanges { one_pool: true },
        ValueRangeParams {
            dims,
            cell_size,
            grid_dims,
            reach,
            bricks,
            first_cell,
            cell_count,
            row_length,
            split_pools,
            padding,
        }
    );
    assert_twin!(
        Kernel::MajorantGrid,
        MajorantParams {
            cell_count,
            majorant_offset,
            row_length,
            cells_per_brick,
            style_count,
            has_labels,
            shape_count,
            has_depth,
            grid_dims,
            cell_size,
            bricks,
            peel_mm,
            dims,
            peel_inverse_width,
            depth_from_voxel,
            depth_grid_dims,
            depth_cell_size,
            depth_scale,
            depth_bias,
            shapes_of_rays,
            padding,
        }
    );
    assert_twin!(
        Kernel::EmptySpace,
        EmptySpaceParams { cell_count, majorant_offset, row_length, axis, grid_dims, padding }
    );
    assert_twin!(
        Kernel::Display,
        DisplayParams { background, background_kind, exposure_scale, tone_operator, inverse_gamma, padding }
    );
    assert_twin!(Kernel::FilmCount, FilmCountParams { pixels, invocations, target_samples, padding });
    assert_twin!(Kernel::FilmCount, FilmCount { samples, short, aside, starved, stuck });
    assert_twin!(
        Kernel::FilmFade,
        FilmFadeParams { film_size, kept, scale, guides, padding_x, padding_y, padding_z }
    );
    assert_twin!(
        Kernel::LightBegin,
        LightParams {
            slots,
            frame,
            points,
            tier,
            kept,
            most_points,
            most_mirrored,
            trusted_points,
            coarse_share,
            coarsest_share,
            is_changing,
            forgets,
            scale,
            padding_x,
            padding_y,
            padding_z,
        }
    );
    assert_twin!(
        Kernel::LightSmooth,
        LightSmoothParams {
            film_size,
            first,
            stride,
            step,
            flips,
            is_last,
            sure,
            pixel_size,
            camera_parallel,
            padding,
        }
    );
    assert_twin!(
        Kernel::LightFill,
        LightFillParams {
            before_from_now,
            film_size,
            first,
            stride,
            has_before,
            camera_parallel,
            keeps,
            light_scale,
            padding_x,
            padding_y,
            padding_z,
        }
    );
    assert_twin!(
        Kernel::HostDepth,
        HostDepthParams {
            view_depth_from_ndc,
            film_size,
            clear,
            jittered,
            farthest,
            guides,
            padding_x,
            padding_y,
        }
    );
    assert_twin!(
        Kernel::DenoisePrepare,
        DenoiseParams { film_size, step, bounded, kept_light, padding_x, padding_y, padding_z }
    );
    assert_twin!(
        Kernel::DenoiseWavelet,
        DenoiseParams { film_size, step, bounded, kept_light, padding_x, padding_y, padding_z }
    );
    for kernel in [Kernel::CompositeColor, Kernel::CompositeDepth] {
        assert_twin!(kernel, CompositeParams { width, padding_x, padding_y, padding_z });
    }
    assert_twin!(
        Kernel::CompositeVelocity,
        VelocityParams {
            before_from_now,
            view_depth_from_ndc,
            scale,
            picture_size,
            camera_parallel,
            padding_x,
            padding_y,
            padding_z
        }
    );
    assert_twin!(
        Kernel::LivePicture,
        LivePictureParams {
            view_depth_from_ndc,
            ndc_from_view_depth,
            picture_size,
            first_size,
            second_size,
            exposure,
            clear,
            has_host_depth,
            denoised,
            camera_parallel,
            fog_kind,
            fog_distance,
            fog_color,
            farthest,
            camera_edges,
            world_height,
            fog_height,
            coarse_alone,
            kept_light,
            film_is_shown,
            padding_x,
            padding_y,
            padding_z,
        }
    );
    assert_twin!(Kernel::SampleDirections, SampleParams { axis, sampler, anisotropy, count, padding });
}

/// Of every fifth: neighbours differ by flags, which a step of a power of two would leave as they are.
#[test]
fn kernels_do_without_uniform_buffers() {
    do_without_uniform_buffers(Kernel::all().step_by(5));
}

#[test]
#[ignore = "slow: script/test --all"]
fn every_kernel_does_without_uniform_buffers() {
    do_without_uniform_buffers(Kernel::all());
}

fn do_without_uniform_buffers(kernels: impl Iterator<Item = Kernel>) {
    for kernel in kernels {
        let text = kernel.wgsl_without_uniforms();
        let module =
            naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
        let is_uniform = |space| matches!(space, naga::AddressSpace::Uniform);
        assert!(
            module.global_variables.iter().all(|(_, variable)| !is_uniform(variable.space)),
            "{kernel:?}"
        );
        let mut validator = naga::valid::Validator::new(Default::default(), CAPABILITIES);
        validator.validate(&module).unwrap_or_else(|e| panic!("{kernel:?}: {}", e.emit_to_string(&text)));
    }
}

/// One by one, and all that is asked of each at once: to parse and validate them takes longest.
#[test]
fn every_kernel_is_as_declared_and_becomes_spirv_1_3_hlsl_and_msl() {
    for kernel in Kernel::all() {
        let module = module(kernel);
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), CAPABILITIES);
        let info = validator.validate(&module).unwrap_or_else(|e| panic!("{kernel:?}: {e:?}"));
        has_bindings_and_workgroups_as_declared(kernel, &module);
        becomes_spirv_1_3_hlsl_and_msl(kernel, &module, &info);
        chooses_vectors_by_one_condition(kernel, &module, &info);
    }
}

fn has_bindings_and_workgroups_as_declared(kernel: Kernel, module: &naga::Module) {
    use naga::{AddressSpace, ImageClass, ImageDimension, StorageAccess, TypeInner};
    let mut found: Vec<(u32, BindingKind)> = module
        .global_variables
        .iter()
        .filter_map(|(_, variable)| {
            let binding = variable.binding.as_ref()?;
            assert_eq!(binding.group, 0);
            let kind = match (variable.space, &module.types[variable.ty].inner) {
                (AddressSpace::Uniform, _) => BindingKind::Uniform,
                (AddressSpace::Storage { access }, _) if access.contains(StorageAccess::STORE) => {
                    BindingKind::StorageReadWrite
                }
                (AddressSpace::Storage { .. }, _) => BindingKind::StorageRead,
                (_, TypeInner::Sampler { .. }) => BindingKind::LinearSampler,
                (_, TypeInner::Image { dim: ImageDimension::D3, class: ImageClass::Sampled { .. }, .. }) => {
                    BindingKind::Texture3d
                }
                (_, TypeInner::Image { dim: ImageDimension::D2, .. }) => BindingKind::Texture2dLoaded,
                other => panic!("{kernel:?}: unexpected global {other:?}"),
            };
            Some((binding.binding, kind))
        })
        .collect();
    found.sort_by_key(|(index, _)| *index);
    let declared: Vec<_> = (0..).zip(kernel.bindings().iter().copied()).collect();
    assert_eq!(found, declared, "{kernel:?}");
    match kernel.kind() {
        KernelKind::Compute => {
            let entry = &module.entry_points[0];
            assert_eq!(entry.name, kernel.entry_point());
            let [x, y] = kernel.workgroup_size();
            assert_eq!(entry.workgroup_size, [x, y, 1], "{kernel:?}");
        }
        KernelKind::DrawColor | KernelKind::DrawOver | KernelKind::DrawDepth => {
            let has = |stage, name| module.entry_points.iter().any(|e| e.stage == stage && e.name == name);
            assert!(has(naga::ShaderStage::Vertex, Kernel::VERTEX_ENTRY_POINT));
            assert!(has(naga::ShaderStage::Fragment, kernel.entry_point()));
        }
    }
}

fn becomes_spirv_1_3_hlsl_and_msl(kernel: Kernel, module: &naga::Module, info: &naga::valid::ModuleInfo) {
    use naga::back::{hlsl, msl, spv};
    let options = spv::Options { lang_version: (1, 3), ..Default::default() };
    let words = spv::write_vec(module, info, &options, None).unwrap();
    assert_eq!(words[0], 0x0723_0203, "SPIR-V's magic number");

    let mut text = String::new();
    let options = hlsl::Options { fake_missing_bindings: true, ..Default::default() };
    let pipeline = hlsl::PipelineOptions::default();
    hlsl::Writer::new(&mut text, &options, &pipeline).write(module, info, None).unwrap();
    assert!(text.contains(kernel.entry_point()));

    let options = msl::Options { fake_missing_bindings: true, ..Default::default() };
    let (text, _) = msl::write_string(module, info, &options, &msl::PipelineOptions::default()).unwrap();
    assert!(text.contains(kernel.entry_point()));
}

/// Microsoft's DXC, which Unity compiles with, takes one condition for all of a vector: `choose.wgsl` is for the others.
fn chooses_vectors_by_one_condition(kernel: Kernel, module: &naga::Module, info: &naga::valid::ModuleInfo) {
    for (handle, function) in module.functions.iter() {
        for (_, expression) in function.expressions.iter() {
            let naga::Expression::Select { condition, .. } = expression else { continue };
            let ty = info[handle][*condition].ty.inner_with(&module.types);
            let name = function.name.as_deref().unwrap_or_default();
            assert!(matches!(ty, naga::TypeInner::Scalar(_)), "{kernel:?}: `select` in {name}");
        }
    }
}

/// WebGPU promises eight storage buffers. A path tracer takes four of them, and in software one for paths that are put aside:
/// the others are left for what paths are to meet besides volumes.
#[test]
fn no_kernel_binds_more_storage_buffers_than_there_are() {
    for kernel in Kernel::all() {
        let is_storage =
            |kind: &&BindingKind| matches!(kind, BindingKind::StorageRead | BindingKind::StorageReadWrite);
        let count = kernel.bindings().iter().filter(is_storage).count();
        let most = match kernel {
            Kernel::PathTrace(variant) if variant.points => 5 + usize::from(variant.limited_turns),
            Kernel::PathTrace(variant) => 4 + usize::from(variant.limited_turns),
            _ => 8,
        };
        assert!(count <= most, "{kernel:?} binds {count}");
    }
}

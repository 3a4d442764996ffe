//! Kernels and programs that naga makes, run on the device that the machine has.

use crate::gpu::{Bind, Gpu, Region, Target};
use crate::pipelines::DrawState;
use crate::spirv::{Kind, Module, Shape};

const R16_UNORM: u32 = 21;
const RGBA32_FLOAT: u32 = 52;
const DEPTH32: u32 = 93;

fn compile(wgsl: &str, entry: &str, stage: naga::ShaderStage) -> Vec<u32> {
    let module = naga::front::wgsl::parse_str(wgsl).unwrap();
    let capabilities = naga::valid::Capabilities::all();
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .unwrap();
    let mut options = naga::back::spv::Options { lang_version: (1, 3), ..Default::default() };
    options.flags |= naga::back::spv::WriterFlags::DEBUG;
    options.flags -= naga::back::spv::WriterFlags::ADJUST_COORDINATE_SPACE;
    let pipeline = naga::back::spv::PipelineOptions { entry_point: entry.into(), shader_stage: stage };
    naga::back::spv::write_vec(&module, &info, &options, Some(&pipeline)).unwrap()
}

fn bind(stage: u32, binding: u32, handle: u32) -> Bind {
    Bind { stage, binding, handle, level: 0, offset: 0, size: 0 }
}

fn bytes(of: &[f32]) -> Vec<u8> {
    of.iter().flat_map(|number| number.to_le_bytes()).collect()
}

fn floats(of: &[u8]) -> Vec<f32> {
    of.chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect()
}

fn no_faults(gpu: &Gpu) {
    assert_eq!(gpu.next_fault(), None);
}

const DOUBLE: &str = "
    @group(0) @binding(3) var<uniform> scale: vec4<f32>;
    @group(0) @binding(7) var<storage, read> source: array<f32>;
    @group(0) @binding(9) var<storage, read_write> result: array<f32>;
    @group(0) @binding(1) var<storage, read> other: array<f32>;
    fn idle() -> f32 { return other[0]; }
    @compute @workgroup_size(4) fn double(@builtin(global_invocation_id) id: vec3<u32>) { result[id.x] = source[id.x] * scale.y; }";

#[test]
fn bindings_are_found_by_name_and_counted_without_gaps() {
    let module = Module::read(compile(DOUBLE, "double", naga::ShaderStage::Compute), 0).unwrap();
    let found: Vec<_> = module.variables.iter().map(|v| (v.name.as_str(), v.binding, v.kind)).collect();
    assert_eq!(
        found,
        [
            ("scale", 0, Kind::Constant),
            ("source", 1, Kind::Buffer { writable: false }),
            ("result", 2, Kind::Buffer { writable: true })
        ]
    );
    assert_eq!((module.entry.as_str(), module.threads), ("double", [4, 1, 1]));
}

#[test]
fn a_kernel_runs_between_the_writes_around_it() {
    let mut gpu = Gpu::open().unwrap();
    let kernel = gpu.create_kernel(compile(DOUBLE, "double", naga::ShaderStage::Compute)).unwrap();
    let (scale, source, result) = (
        gpu.create_buffer(16, true).unwrap(),
        gpu.create_buffer(16, false).unwrap(),
        gpu.create_buffer(16, false).unwrap(),
    );
    gpu.write_buffer(source, 0, &bytes(&[1.0, 2.0, 3.0, 4.0])).unwrap();
    let mut tickets = Vec::new();
    for factor in [2.0, 3.0] {
        gpu.write_buffer(scale, 0, &bytes(&[0.0, factor, 0.0, 0.0])).unwrap();
        gpu.dispatch(kernel, &[bind(0, 0, scale), bind(0, 1, source), bind(0, 2, result)], [1, 1, 1])
            .unwrap();
        tickets.push(gpu.read_buffer(result, 4, 8).unwrap());
    }
    gpu.submit();
    assert_eq!(gpu.submissions, 1);
    let mut read = [0; 8];
    for (ticket, expected) in tickets.into_iter().zip([[4.0, 6.0], [6.0, 9.0]]) {
        gpu.collect(ticket, &mut read).unwrap();
        assert_eq!(floats(&read), expected);
    }
    no_faults(&gpu);
}

#[test]
fn a_kernel_writes_texels_of_16_bits() {
    let mut gpu = Gpu::open().unwrap();
    // WGSL knows no such format; the texture's own counts.
    let code = "
        @group(0) @binding(0) var atlas: texture_storage_3d<r32float, write>;
        @compute @workgroup_size(1) fn fill(@builtin(global_invocation_id) id: vec3<u32>) {
            textureStore(atlas, id, vec4(f32(id.x + id.y + id.z) / 65535.0, 0.0, 0.0, 0.0));
        }";
    let module = compile(code, "fill", naga::ShaderStage::Compute);
    assert_eq!(Module::read(module.clone(), 0).unwrap().variables[0].kind, Kind::Image(Shape::Solid));
    let kernel = gpu.create_kernel(module).unwrap();
    let texture = gpu.create_texture(R16_UNORM, 3, [4, 3, 2], 1, true, false).unwrap();
    gpu.dispatch(kernel, &[bind(0, 0, texture)], [4, 3, 2]).unwrap();
    let all = Region { texture, level: 0, origin: [0; 3] };
    gpu.write_texture(Region { origin: [3, 2, 1], ..all }, [1, 1, 1], &[7, 0]).unwrap();
    let ticket = gpu.read_texture(all, [4, 3, 2]).unwrap();
    gpu.submit();
    let mut read = [0; 48];
    gpu.collect(ticket, &mut read).unwrap();
    let texels: Vec<u16> = read.chunks_exact(2).map(|two| u16::from_le_bytes([two[0], two[1]])).collect();
    let mut expected: Vec<u16> = (0..24).map(|i| i % 4 + i / 4 % 3 + i / 12).collect();
    expected[23] = 7;
    assert_eq!(texels, expected);
    no_faults(&gpu);
}

const TRIANGLE: &str = "
    @group(0) @binding(0) var<uniform> tint: vec4<f32>;
    @group(0) @binding(1) var host_depth: texture_depth_2d;
    @vertex fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
        return vec4(f32(i / 2u) * 4.0 - 1.0, f32(i % 2u) * 4.0 - 1.0, 0.5, 1.0);
    }
    @fragment fn paint(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
        return tint * textureLoad(host_depth, vec2<i32>(at.xy), 0);
    }";

#[test]
fn a_program_blends_and_tests_depth() {
    let mut gpu = Gpu::open().unwrap();
    let program = gpu
        .create_program(
            compile(TRIANGLE, "cover", naga::ShaderStage::Vertex),
            compile(TRIANGLE, "paint", naga::ShaderStage::Fragment),
        )
        .unwrap();
    let color = gpu.create_texture(RGBA32_FLOAT, 2, [2, 2, 1], 1, false, true).unwrap();
    let [depth, host] = [0, 1].map(|_| gpu.create_texture(DEPTH32, 2, [2, 2, 1], 1, false, true).unwrap());
    let tint = gpu.create_buffer(16, true).unwrap();
    gpu.write_buffer(tint, 0, &bytes(&[0.5, 0.25, 0.0, 0.5])).unwrap();
    let target = Target { color, color_layer: 0, depth, depth_layer: 0, viewport: [0.0; 4] };
    gpu.clear(&target, Some([1.0; 4]), Some(0.75)).unwrap();
    gpu.clear(&Target { color: 0, depth: host, ..target }, None, Some(1.0)).unwrap();
    // One, OneMinusSrcAlpha; passes where it is nearer (reversed).
    let state = DrawState {
        blend: 1,
        blend_factors: [1, 10, 0, 1, 10, 0],
        color_mask: 15,
        depth_write: 1,
        depth_test: 7,
        cull: 0,
        topology: 0,
    };
    let binds = [bind(1, 0, tint), bind(1, 1, host)];
    let read = |gpu: &mut Gpu| {
        let ticket =
            gpu.read_texture(Region { texture: color, level: 0, origin: [0; 3] }, [2, 2, 1]).unwrap();
        gpu.submit();
        let mut read = [0; 64];
        gpu.collect(ticket, &mut read).unwrap();
        floats(&read)
    };
    gpu.draw(program, &target, state, &binds, 3, 1).unwrap();
    assert_eq!(read(&mut gpu), [1.0; 16], "0.5 is behind 0.75");
    gpu.clear(&Target { color: 0, ..target }, None, Some(0.25)).unwrap();
    gpu.draw(program, &target, state, &binds, 3, 1).unwrap();
    assert_eq!(read(&mut gpu), [1.0, 0.75, 0.5, 1.0].repeat(4));
    no_faults(&gpu);
}

#[test]
fn faults_are_told() {
    let mut gpu = Gpu::open().unwrap();
    let buffer = gpu.create_buffer(16, false).unwrap();
    gpu.free(buffer).unwrap();
    assert!(gpu.write_buffer(buffer, 0, &[0; 4]).unwrap_err().contains("after it was freed"));
    assert!(gpu.free(buffer).is_err());
    let kernel = gpu.create_kernel(compile(DOUBLE, "double", naga::ShaderStage::Compute)).unwrap();
    assert_eq!(gpu.dispatch(kernel, &[], [1; 3]).unwrap_err(), "double binds nothing to scale");
    assert!(gpu.create_texture(9999, 2, [1; 3], 1, false, false).is_err());
}

//! Recordings as flat structs: what C# walks through, without a copy of any payload.

use std::collections::HashMap;
use std::ffi::{CString, c_char};
use std::sync::{LazyLock, Mutex, PoisonError};

use lumivox_renderer::recording::{Kernel, TextureFormat};
use lumivox_renderer::stage::Recorded;
use lumivox_renderer::{Recording, Step};

use crate::abi::{LumivoxSlice, LumivoxStep, LumivoxStepKind};
use crate::border::{guard, guard_quietly, known};

/// A recording under way, and its steps as C sees them.
pub struct LumivoxRecording {
    pub(crate) recorded: Recorded<u64, u64>,
    flat: FlatSteps,
}

/// Steps, with what they point to. The payloads belong to the recording that they were made of.
#[derive(Default)]
pub struct FlatSteps {
    steps: Vec<LumivoxStep>,
    slices: Vec<LumivoxSlice>,
    resources: Vec<u64>,
}

impl LumivoxRecording {
    pub(crate) fn new(recorded: Recorded<u64, u64>) -> Self {
        Self { flat: FlatSteps::new(&recorded.recording), recorded }
    }

    /// What the flat steps were made of.
    pub fn recording(&self) -> &Recording {
        &self.recorded.recording
    }
}

/// One of no stage's.
impl From<Recording> for LumivoxRecording {
    fn from(recording: Recording) -> Self {
        Self::new(recording.into())
    }
}

impl FlatSteps {
    /// The steps of a recording, which must outlive them.
    pub fn new(recording: &Recording) -> Self {
        let mut flat = Self::default();
        let (mut slices, mut resources) = (0, 0);
        for step in &recording.steps {
            if let Step::Dispatch { uniforms, resources: bound, .. }
            | Step::Draw { uniforms, resources: bound, .. } = step
            {
                slices += uniforms.len();
                resources += bound.len();
            }
        }
        // Steps point into these: they must not move.
        flat.slices.reserve_exact(slices);
        flat.resources.reserve_exact(resources);
        flat.steps.reserve_exact(recording.steps.len());
        for step in &recording.steps {
            let step = flat.flatten(step);
            flat.steps.push(step);
        }
        flat
    }

    /// The steps.
    pub fn steps(&self) -> &[LumivoxStep] {
        &self.steps
    }

    fn flatten(&mut self, step: &Step) -> LumivoxStep {
        use LumivoxStepKind as Kind;
        match step {
            Step::CreateBuffer { id, label, size } => {
                LumivoxStep { id: id.0, label: interned(label), length: *size, ..empty(Kind::CreateBuffer) }
            }
            Step::CreateTexture { id, label, format, size } => LumivoxStep {
                id: id.0,
                label: interned(label),
                format: match format {
                    TextureFormat::R8Unorm => 0,
                    TextureFormat::R16Unorm => 1,
                    TextureFormat::Rg8Unorm => unreachable!("Unity's kernels write no texels of two bytes"),
                    TextureFormat::R16Float => 2,
                    TextureFormat::Rgba32Float => 3,
                },
                size: *size,
                ..empty(Kind::CreateTexture)
            },
            Step::WriteBuffer { id, offset, data } => LumivoxStep {
                id: id.0,
                offset: *offset,
                data: data.bytes().as_ptr(),
                length: data.bytes().len() as u64,
                ..empty(Kind::WriteBuffer)
            },
            Step::WriteTexture { id, origin, size, data } => LumivoxStep {
                id: id.0,
                origin: *origin,
                size: *size,
                data: data.bytes().as_ptr(),
                length: data.bytes().len() as u64,
                ..empty(Kind::WriteTexture)
            },
            Step::CopyTexture { from, to, origin, size } => LumivoxStep {
                id: to.0,
                from: from.0,
                origin: *origin,
                size: *size,
                ..empty(Kind::CopyTexture)
            },
            Step::ClearBuffer { id } => LumivoxStep { id: id.0, ..empty(Kind::ClearBuffer) },
            Step::Dispatch { kernel, uniforms, resources, workgroups } => LumivoxStep {
                workgroups: *workgroups,
                ..self.bound(Kind::Dispatch, *kernel, uniforms, resources.iter().map(|id| id.0))
            },
            Step::Draw { kernel, uniforms, resources, target } => LumivoxStep {
                id: target.0,
                ..self.bound(Kind::Draw, *kernel, uniforms, resources.iter().map(|id| id.0))
            },
            Step::ReadBuffer { id, range } => LumivoxStep {
                id: id.0,
                offset: range.start,
                length: range.end - range.start,
                ..empty(Kind::ReadBuffer)
            },
            Step::Free { id } => LumivoxStep { id: id.0, ..empty(Kind::Free) },
        }
    }

    fn bound(
        &mut self,
        kind: LumivoxStepKind,
        kernel: Kernel,
        uniforms: &[Vec<u8>],
        resources: impl Iterator<Item = u64>,
    ) -> LumivoxStep {
        let (slice, resource) = (self.slices.len(), self.resources.len());
        let slices =
            uniforms.iter().map(|bytes| LumivoxSlice { data: bytes.as_ptr(), length: bytes.len() as u64 });
        self.slices.extend(slices);
        self.resources.extend(resources);
        LumivoxStep {
            kernel: kernel_index(kernel),
            uniforms: self.slices[slice..].as_ptr(),
            uniform_count: (self.slices.len() - slice) as u32,
            resources: self.resources[resource..].as_ptr(),
            resource_count: (self.resources.len() - resource) as u32,
            ..empty(kind)
        }
    }
}

/// A step that says nothing but its kind.
fn empty(kind: LumivoxStepKind) -> LumivoxStep {
    LumivoxStep {
        kind,
        format: 0,
        id: 0,
        from: 0,
        origin: [0; 3],
        size: [0; 3],
        offset: 0,
        length: 0,
        data: std::ptr::null(),
        label: std::ptr::null(),
        kernel: 0,
        uniform_count: 0,
        uniforms: std::ptr::null(),
        resources: std::ptr::null(),
        resource_count: 0,
        workgroups: [0; 2],
        padding: 0,
    }
}

/// A label as C has it, for good.
fn interned(label: &'static str) -> *const c_char {
    static LABELS: LazyLock<Mutex<HashMap<&str, CString>>> = LazyLock::new(Mutex::default);
    let mut labels = LABELS.lock().unwrap_or_else(PoisonError::into_inner);
    // The characters stay where they are when the map grows.
    labels.entry(label).or_insert_with(|| CString::new(label).unwrap_or_default()).as_ptr()
}

/// Every kernel by name, and where it is in that list.
static KERNELS: LazyLock<(Vec<CString>, HashMap<Kernel, u32>)> = LazyLock::new(|| {
    let all: Vec<Kernel> = Kernel::all().collect();
    let names = all.iter().map(|kernel| CString::new(kernel.name()).unwrap_or_default()).collect();
    (names, all.into_iter().zip(0..).collect())
});

fn kernel_index(kernel: Kernel) -> u32 {
    KERNELS.1.get(&kernel).copied().unwrap_or(u32::MAX)
}

/// How many kernels there are, in all variants: more than Unity's half has.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_kernel_count() -> u32 {
    guard_quietly(0, || KERNELS.0.len() as u32)
}

/// The name of a step's kernel, which is that of its file; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_kernel_name(index: u32) -> *const c_char {
    guard_quietly(std::ptr::null(), || {
        KERNELS.0.get(index as usize).map_or(std::ptr::null(), |name| name.as_ptr())
    })
}

/// The steps of a recording, in order; valid until it is finished.
///
/// # Safety
/// `recording` is a live handle, `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_recording_steps(
    recording: *const LumivoxRecording,
    count: *mut u32,
) -> *const LumivoxStep {
    let steps = guard(|| {
        // SAFETY: as the caller promises.
        let steps = unsafe { known(recording, "recording") }?.flat.steps();
        if !count.is_null() {
            // SAFETY: as the caller promises.
            unsafe { count.write(steps.len() as u32) };
        }
        Ok(steps.as_ptr())
    });
    steps.unwrap_or(std::ptr::null())
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use lumivox_renderer::ResourceId;
    use lumivox_renderer::recording::Payload;

    use super::*;

    #[test]
    fn steps_point_into_their_recording() {
        let [a, b] = [ResourceId::external(), ResourceId::external()];
        let data = Payload::copy_of(&[1u32, 2, 3]);
        let bytes = data.bytes().as_ptr();
        let recording = Recording {
            steps: vec![
                Step::CreateBuffer { id: a, label: "films", size: 64 },
                Step::WriteBuffer { id: a, offset: 4, data },
                Step::Dispatch {
                    kernel: Kernel::FilmCount,
                    uniforms: vec![vec![7; 16]],
                    resources: vec![a, b],
                    workgroups: [3, 4],
                },
                Step::ReadBuffer { id: b, range: 8..24 },
            ],
        };
        let flat = FlatSteps::new(&recording);
        let [create, write, dispatch, read] = flat.steps() else { panic!("four steps") };
        // SAFETY: labels live for good.
        assert_eq!(unsafe { CStr::from_ptr(create.label) }, c"films");
        assert_eq!((write.offset, write.length, write.data), (4, 12, bytes));
        // SAFETY: so many are there.
        let bound =
            unsafe { std::slice::from_raw_parts(dispatch.resources, dispatch.resource_count as usize) };
        assert_eq!(bound, [a.0, b.0]);
        // SAFETY: there is one of 16 bytes.
        let uniform = unsafe { std::slice::from_raw_parts((*dispatch.uniforms).data, 16) };
        assert_eq!((uniform, dispatch.uniform_count, dispatch.workgroups), (&[7; 16][..], 1, [3, 4]));
        // SAFETY: names live for good.
        assert_eq!(unsafe { CStr::from_ptr(lumivox_kernel_name(dispatch.kernel)) }, c"film_count");
        assert_eq!((read.kind, read.offset, read.length), (LumivoxStepKind::ReadBuffer, 8, 16));
    }
}

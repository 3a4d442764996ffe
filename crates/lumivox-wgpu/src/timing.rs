//! What the passes of a submission take on the GPU, by its own clock.
//!
//! Timestamps are written where the first pass begins and the last one ends, which every device with
//! `TIMESTAMP_QUERY` can do; uploads and copies before, between and after passes count as far as those lie in between.
//!
//! Software Vulkan (lavapipe) takes the time of a timestamp with whatever it draws next, so that the first dispatch after
//! it would be missed: there it is written in a submission of its own, at the end of which all is done.

use std::sync::{Arc, Mutex, PoisonError};

use crate::submission::{Mapping, poll};

/// Bytes of two timestamps.
const BYTES: u64 = 16;

/// Slots that are kept for later submissions.
const SPARE_SLOTS: usize = 8;

/// Two timestamps, and the way back to the CPU.
#[derive(Debug)]
struct Slot {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    returned: wgpu::Buffer,
}

/// Times submissions, where the device can.
#[derive(Clone, Debug)]
pub(crate) struct Timer {
    /// Nanoseconds of a tick.
    period: f64,
    /// Whether the first timestamp has to be submitted before everything else.
    ahead: bool,
    spare: Arc<Mutex<Vec<Slot>>>,
}

impl Timer {
    /// `None` where the device tells no times.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        let period = f64::from(queue.get_timestamp_period());
        let tells = device.features().contains(wgpu::Features::TIMESTAMP_QUERY) && period > 0.0;
        let ahead = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        tells.then(|| Self { period, ahead, spare: Arc::default() })
    }

    /// Whether it needs no submission of its own.
    pub fn times_within_an_encoder(&self) -> bool {
        !self.ahead
    }

    /// For a submission of so many passes, of which there is one at least.
    pub fn begin(&self, device: &wgpu::Device, queue: &wgpu::Queue, passes: usize) -> Timing {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let slot = spare.unwrap_or_else(|| {
            let buffer = |label, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: BYTES,
                    usage,
                    mapped_at_creation: false,
                })
            };
            Slot {
                queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("times"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2,
                }),
                resolved: buffer("times", wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
                returned: buffer("times, back", wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
            }
        });
        if self.ahead {
            let mut encoder = device.create_command_encoder(&Default::default());
            let writes = wgpu::ComputePassTimestampWrites {
                query_set: &slot.queries,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: None,
            };
            let label = Some("time");
            drop(
                encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label,
                    timestamp_writes: Some(writes),
                }),
            );
            queue.submit([encoder.finish()]);
        }
        let spare = self.spare.clone();
        Timing { slot, passes, begun: 0, has_begin: self.ahead, period: self.period, spare }
    }
}

/// The timestamps of a submission while it is encoded.
#[derive(Debug)]
pub(crate) struct Timing {
    slot: Slot,
    passes: usize,
    begun: usize,
    has_begin: bool,
    period: f64,
    spare: Arc<Mutex<Vec<Slot>>>,
}

/// The queries that a pass writes where it begins and where it ends.
type Writes<'a> = (&'a wgpu::QuerySet, Option<u32>, Option<u32>);

impl Timing {
    fn next(&mut self) -> Option<Writes<'_>> {
        let is_first = self.begun == 0 && !self.has_begin;
        self.begun += 1;
        let is_last = self.begun == self.passes;
        (is_first || is_last).then(|| (&self.slot.queries, is_first.then_some(0), is_last.then_some(1)))
    }

    /// What the next pass writes, if it computes.
    pub fn next_compute(&mut self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let (query_set, beginning_of_pass_write_index, end_of_pass_write_index) = self.next()?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index,
            end_of_pass_write_index,
        })
    }

    /// What the next pass writes, if it draws.
    pub fn next_render(&mut self) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let (query_set, beginning_of_pass_write_index, end_of_pass_write_index) = self.next()?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index,
            end_of_pass_write_index,
        })
    }

    /// Behind the last pass.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.slot.queries, 0..2, &self.slot.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.slot.resolved, 0, &self.slot.returned, 0, BYTES);
    }

    /// Once everything is submitted.
    pub fn submitted(self, device: &wgpu::Device) -> GpuTime {
        let mapping = Mapping::begin(&self.slot.returned);
        self.under_way(device, mapping)
    }

    /// Where the host will submit it.
    pub fn on_submit(self, device: &wgpu::Device, encoder: &wgpu::CommandEncoder) -> GpuTime {
        let mapping = Mapping::on_submit(&self.slot.returned, encoder);
        self.under_way(device, mapping)
    }

    fn under_way(self, device: &wgpu::Device, mapping: Mapping) -> GpuTime {
        let under_way = Some((self.slot, mapping));
        let (period, spare) = (self.period, self.spare);
        GpuTime { device: device.clone(), under_way, milliseconds: 0.0, period, spare }
    }
}

/// What the passes of a submission take on the GPU. Known frames later: ask for it now and then, as
/// [`Pacer::measured`](lumivox_renderer::pacing::Pacer::measured) wants it.
#[derive(Debug)]
pub struct GpuTime {
    device: wgpu::Device,
    under_way: Option<(Slot, Mapping)>,
    milliseconds: f64,
    /// Nanoseconds of a tick.
    period: f64,
    spare: Arc<Mutex<Vec<Slot>>>,
}

impl GpuTime {
    /// Milliseconds from the beginning of the first pass to the end of the last; `None` while they are not known, and 0
    /// where the device lost them. Never waits.
    pub fn poll(&mut self) -> Option<f64> {
        let Some((_, mapping)) = &mut self.under_way else { return Some(self.milliseconds) };
        let polled = poll(&self.device, wgpu::PollType::Poll);
        let is_mapped = match (polled, mapping.poll()) {
            (_, Some(Ok(()))) => true,
            (Ok(_), None) => return None,
            _ => false,
        };
        let (slot, _) = self.under_way.take()?;
        if is_mapped {
            let bytes = slot.returned.slice(..).get_mapped_range().to_vec();
            let ticks = [&bytes[..8], &bytes[8..]]
                .map(|bytes| bytes.try_into().map(u64::from_le_bytes).unwrap_or_default());
            self.milliseconds = milliseconds(ticks, self.period);
            slot.returned.unmap();
            let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
            if spare.len() < SPARE_SLOTS {
                spare.push(slot);
            }
        }
        Some(self.milliseconds)
    }
}

/// From one timestamp to the other, of ticks of so many nanoseconds; 0 where the clock began anew in between.
fn milliseconds([begin, end]: [u64; 2], period: f64) -> f64 {
    // The difference first: a clock that has run for weeks has more digits than a float.
    end.checked_sub(begin).map_or(0.0, |ticks| ticks as f64 * period * 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_milliseconds_whatever_the_period_and_however_late() {
        let weeks = 1 << 62;
        assert_eq!(milliseconds([weeks, weeks + 1_000_000], 1.0), 1.0);
        // Intel's 12 MHz and 19.2 MHz, AMD's 100 MHz.
        for period in [83.333_336, 52.083_332, 10.0] {
            let got = milliseconds([weeks + 1, weeks + 48_001], period);
            assert!((got - 48e3 * period * 1e-6).abs() < 1e-9, "{got}");
        }
        assert_eq!(milliseconds([7, 7], 40.0), 0.0);
        assert_eq!(milliseconds([1 << 36, 5], 40.0), 0.0, "a clock of 36 bits that began anew");
    }
}

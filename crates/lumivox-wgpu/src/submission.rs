//! What comes back of a recording that was handed to the GPU: bytes, faults and time, none of which has to be waited for.

use std::future::Future;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::sync::mpsc;
use std::task::{Context, Poll, Waker};

use crate::error::GpuError;
use crate::timing::GpuTime;

/// A recording under way on the GPU.
#[derive(Debug)]
#[non_exhaustive]
pub struct Submission {
    /// What its steps bring back, in their order. They mean nothing where the device refused a step.
    pub read_backs: Vec<ReadBack>,
    /// What its passes take; `None` where it has none, or the device tells no times.
    pub time: Option<GpuTime>,
    pub(crate) faults: Faults,
}

impl Submission {
    /// Whether the device took every step. Ready at once but in browsers, where it must not be blocked on.
    ///
    /// # Errors
    /// [`GpuError`] when the device ran out of memory or refused a step: what the recording made should be
    /// [discarded](crate::Executor::discard) then. The executor goes on to work.
    pub async fn check(&mut self) -> Result<(), GpuError> {
        (&mut self.faults).await
    }

    /// What [`check`](Self::check) says, for hosts that ask in every frame; `None` while it is not known.
    pub fn poll_check(&mut self) -> Option<Result<(), GpuError>> {
        at_once(&mut self.faults)
    }
}

/// What a future gives without being waited for.
pub(crate) fn at_once<T>(future: impl Future<Output = T> + Unpin) -> Option<T> {
    let mut future = future;
    match Pin::new(&mut future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => Some(result),
        Poll::Pending => None,
    }
}

#[cfg(not(target_family = "wasm"))]
type Popped = Pin<Box<dyn Future<Output = Option<wgpu::Error>> + Send>>;
#[cfg(target_family = "wasm")]
type Popped = Pin<Box<dyn Future<Output = Option<wgpu::Error>>>>;

/// Scopes around commands, in which their faults are caught.
pub(crate) struct Scopes([wgpu::ErrorScopeGuard; 3]);

impl Scopes {
    pub fn push(device: &wgpu::Device) -> Self {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        Self([OutOfMemory, Validation, Internal].map(|filter| device.push_error_scope(filter)))
    }

    /// Ends them; what they caught may be known later.
    pub fn pop(self) -> Faults {
        // Scopes nest: the innermost is popped first.
        let [memory, validation, internal] = self.0;
        let internal: Popped = Box::pin(internal.pop());
        let validation: Popped = Box::pin(validation.pop());
        let memory: Popped = Box::pin(memory.pop());
        // Want of memory makes what follows invalid: the cause is told first.
        Faults { awaited: vec![internal, validation, memory], first: Ok(()) }
    }
}

/// What scopes caught, as a future.
pub(crate) struct Faults {
    /// Those whose scopes have not told; the most telling last.
    awaited: Vec<Popped>,
    first: Result<(), GpuError>,
}

impl Default for Faults {
    fn default() -> Self {
        Self { awaited: vec![], first: Ok(()) }
    }
}

impl std::fmt::Debug for Faults {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Faults").field("known", &self.awaited.is_empty()).field("first", &self.first).finish()
    }
}

impl Future for Faults {
    type Output = Result<(), GpuError>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        while let Some(scope) = self.awaited.last_mut() {
            let Poll::Ready(error) = scope.as_mut().poll(context) else { return Poll::Pending };
            self.awaited.pop();
            if let (Some(error), Ok(())) = (error, &self.first) {
                self.first = Err(match error {
                    wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory(error.to_string()),
                    _ => GpuError::Refused(error.to_string()),
                });
            }
        }
        Poll::Ready(self.first.clone())
    }
}

/// Has the device look what is done. wgpu panics where the device was lost.
pub(crate) fn poll(device: &wgpu::Device, how: wgpu::PollType) -> Result<(), GpuError> {
    let polled = catch_unwind(AssertUnwindSafe(|| device.poll(how)));
    match polled {
        Ok(Ok(_)) => Ok(()),
        Ok(Err(error)) => Err(GpuError::Lost(error.to_string())),
        Err(_) => Err(GpuError::Lost("it does not answer".to_owned())),
    }
}

/// Bytes on their way back from the GPU.
#[derive(Debug)]
pub struct ReadBack {
    device: wgpu::Device,
    buffer: wgpu::Buffer,
    /// `None` where it is the host's, or will be.
    submission: Option<wgpu::SubmissionIndex>,
    mapping: Mapping,
}

impl ReadBack {
    /// Of a buffer to which the commands of a submission copy.
    pub(crate) fn new(
        device: wgpu::Device,
        buffer: wgpu::Buffer,
        submission: Option<wgpu::SubmissionIndex>,
    ) -> Self {
        Self { device, mapping: Mapping::begin(&buffer), buffer, submission }
    }

    /// Of a buffer to which the commands of an encoder copy that the host will submit.
    pub(crate) fn on_submit(
        device: wgpu::Device,
        buffer: wgpu::Buffer,
        encoder: &wgpu::CommandEncoder,
    ) -> Self {
        Self { device, mapping: Mapping::on_submit(&buffer, encoder), buffer, submission: None }
    }

    /// The bytes, as soon as they are there; never waits.
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device is gone.
    pub fn poll(&mut self) -> Option<Result<Vec<u8>, GpuError>> {
        if let Err(error) = poll(&self.device, wgpu::PollType::Poll) {
            return Some(Err(error));
        }
        let mapped = self.mapping.poll()?;
        Some(mapped.map(|()| self.buffer.slice(..).get_mapped_range().to_vec()))
    }

    /// Waits for the bytes, of which the commands have been submitted. Not in browsers, whose own loop has to run until they are there: see [`poll`](Self::poll).
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device is gone.
    pub fn wait(mut self) -> Result<Vec<u8>, GpuError> {
        let wait = wgpu::PollType::Wait { submission_index: self.submission.clone(), timeout: None };
        poll(&self.device, wait)?;
        let nothing = || Err(GpuError::Lost("the bytes of a read-back did not come".to_owned()));
        self.poll().unwrap_or_else(nothing)
    }
}

/// A buffer that gets mapped once what was submitted before is done.
#[derive(Debug)]
pub(crate) struct Mapping {
    told: mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>,
    known: Option<Result<(), GpuError>>,
}

impl Mapping {
    pub fn begin(buffer: &wgpu::Buffer) -> Self {
        let (told, tell) = Self::told();
        buffer.slice(..).map_async(wgpu::MapMode::Read, tell);
        told
    }

    /// Once the commands of an encoder are submitted.
    pub fn on_submit(buffer: &wgpu::Buffer, encoder: &wgpu::CommandEncoder) -> Self {
        let (told, tell) = Self::told();
        encoder.map_buffer_on_submit(buffer, wgpu::MapMode::Read, .., tell);
        told
    }

    fn told() -> (Self, impl FnOnce(Result<(), wgpu::BufferAsyncError>) + Send + 'static) {
        let (send, told) = mpsc::channel();
        // Nobody listens any more where the read-back was dropped.
        let tell = move |result| _ = send.send(result);
        (Self { told, known: None }, tell)
    }

    /// Whether the buffer can be read, once the device was polled.
    pub fn poll(&mut self) -> Option<Result<(), GpuError>> {
        if self.known.is_none() {
            self.known = match self.told.try_recv() {
                Ok(result) => Some(result.map_err(|e| GpuError::Lost(e.to_string()))),
                Err(mpsc::TryRecvError::Empty) => None,
                Err(mpsc::TryRecvError::Disconnected) => Some(Err(GpuError::Lost(
                    "the commands that bring bytes back were never submitted".to_owned(),
                ))),
            };
        }
        self.known.clone()
    }
}
